// Brings a saved page to the row under the crosshair, as the server does: slices, motion, numbers; the map by its menu.
const plan = JSON.parse(plan_text)
const index_of = (values, at) => {
  let best = 0
  for (let n = 1; n < values.length; n++) if (Math.abs(values[n] - at) < Math.abs(values[best] - at)) best = n
  return best
}
const axes = [x_axis.data.at, y_axis.data.at].filter((values) => values.length > 0)
const at = axes.map((values, n) => index_of(values, (n == 0 ? crosshair.data.x : crosshair.data.y)[0]))
const others = menus.reduce((sum, menu, n) => sum + plan.menus[n] * menu.options.indexOf(menu.value), 0)
const row_at = (place, extra) => others + extra + place.reduce((sum, n, axis) => sum + n * plan.strides[axis], 0)
const shown = plan.series.findIndex((series) => series.label == quantity.value)
const codes = rows.data.code, column = (n) => fields.data[plan.series[n].key]
const colour = (code) => plan.regions[code].colour

const show_map = () => {
  const [nx, ny] = axes.map((values) => values.length)
  const picture = new Float32Array(plan.columns.length * plan.rows.length)
  const values = shown < 0 ? codes : column(shown)
  plan.rows.forEach((j, n) => plan.columns.forEach((i, m) => {
    picture[n * plan.columns.length + m] = values[row_at([i, j], 0)]
  }))
  picture.shape = [plan.rows.length, plan.columns.length]
  const limits = shown < 0 ? [-0.5, plan.regions.length - 0.5] : plan.series[shown].limits
  const own = shown < 0 ? plan.regions.map((each) => each.colour) : plan.series[shown].palette
  mapper.setv({palette: own ?? plan.palette, low: limits[0], high: limits[1]})
  bar.visible = own == null
  regions.data = {text: shown < 0 ? plan.regions.map((each) => each.text) : plan.series[shown].texts}
  words.data = shown < 0 && others == plan.drawn ? plan.words : {x: [], y: [], text: [], align: []}
  if (others != plan.drawn) outlines.data = {x: [], y: []}
  image.data = {...image.data, image: [ndarray(picture, [plan.rows.length, plan.columns.length])]}
}
const ndarray = (values, shape) => {
  const old = image.data.image[0]
  return new old.constructor(values, shape)
}

const show_slice = (axis, points, lines) => {
  const found = {at: [], value: [], colour: [], marker: []}, curves = {at: [], value: []}
  const chosen = shown < 0 ? plan.of_regions : [shown]
  // curves of all directions, whichever the menu has
  const way = plan.way < 0 ? 0 : plan.menus[plan.way] * menus[plan.way].options.indexOf(menus[plan.way].value)
  chosen.forEach((n, first) => plan.directions.forEach((extra, second) => {
    for (let i = 0; i < axes[axis].length; i++) {
      const row = row_at(at.map((each, k) => (k == axis ? i : each)), extra - way), value = column(n)[row]
      found.at.push(axes[axis][i])
      found.value.push(value)
      found.colour.push(colour(codes[row]))
      found.marker.push(plan.markers[(first * plan.directions.length + second) % plan.markers.length])
      curves.at.push(axes[axis][i])
      curves.value.push(value)
    }
    curves.at.push(NaN)
    curves.value.push(NaN)
  }))
  points.data = found
  lines.data = curves
}

const exciter_at = () => {
  const p = {...plan.exciter}
  plan.axes.forEach((name, n) => { if (name) p[name] = axes[n][at[n]] * plan.factors[n] })
  menus.forEach((menu, n) => { if (plan.menu_names[n]) p[plan.menu_names[n]] = Number(menu.value) * plan.menu_factors[n] })
  return {...p, upper: p.l + p.delta, lower: p.delta - p.l}
}

const show_motion = (row) => {
  const p = exciter_at(), m = rows.data.multiple[row], period = 2 * Math.PI / p.nu
  const events = []
  for (let i = rows.data.first[row]; i < rows.data.first[row] + rows.data.count[row]; i++) {
    const side = events_source.data.support[i], velocity = events_source.data.velocity[i]
    events.push([events_source.data.time[i] * period, side < 0 ? velocity * period : velocity, side])
  }
  const is_known = rows.data.known[row] == 1
  const {time, x: plain_x, v} = is_known ? rebuild(p, events, m * period, 256) : {time: [], x: [], v: []}
  const long = plan.scale.length, x = plain_x.map((each) => each * long), upper = p.upper * long, lower = p.lower * long
  const wide = Math.max(...x.filter(Number.isFinite).map(Math.abs), 1e-300)
  const ends = [...x.filter(Number.isFinite), ...[upper, lower].filter((each) => Math.abs(each) <= plan.far * wide)]
  motion.data = {time: time.map((t) => t * plan.scale.time), x, v: v.map((each) => each * plan.scale.velocity)}
  motion.tags = [period * plan.scale.time]
  const hits = is_known ? events.filter(([, , side]) => side > 0) : []
  jumps.data = {
    time: hits.map(([t]) => t * plan.scale.time), x: hits.map(([, , side]) => wall(p, side) * long),
    before: hits.map(([, velocity]) => velocity * plan.scale.velocity),
    after: hits.map((hit) => after(p, hit, 0).v * plan.scale.velocity),
    colour: hits.map(([, , side]) => plan.support_colours[side - 1]),
  }
  section.data = {x: [], v: []}
  if (x.length == 0) return
  const low = Math.min(...ends), high = Math.max(...ends), margin = plan.margin * (high - low || 1)
  x_range.setv({start: low - margin, end: high + margin})
  const half = 0.5 * plan.mass * (high - low + 2 * margin)
  drawing_range.setv({start: low - margin - half, end: high + margin + half})
  mass.data = {x: [x[0]], width: [2 * half]}
  const coils = spring.data.y, left = Math.max(low - margin, lower) - half
  spring.data = {x: Array.from(coils, (_, n) => left + (x[0] - left) * n / (coils.length - 1)), y: coils}
  walls.forEach((box, n) => {
    const side = n < 2 ? ["bottom", "top"] : ["left", "right"], moved = n > 3 ? half : 0
    if (n % 2 == 0) box[side[0]] = upper + moved
    else box[side[1]] = lower - moved
  })
}

const number = (value) => (Number.isFinite(value) ? String(Number(value.toPrecision(6))).replace(/-/g, "−") : "–")
const line = (mark, name, text) => `<tr><td><i>${mark}</i></td><td>${name}</td><td>${text}</td></tr>`
const parameters = () => plan.parameters.map(({mark, name, text, axis, menu, unit}) => line(mark, name,
  text ?? (menu < 0 ? number(axes[axis][at[axis]]) + unit : menus[menu].value + unit)))
const show_numbers = (row) => {
  const place = plan.axis_marks.map((mark, n) => `${mark} = ${number(axes[n][at[n]])}`)
  const text = rows.data.known[row] == 1 ? "" : plan.unknown
  menus.forEach((menu, n) => place.push(`${plan.menu_marks[n]} = ${menu.value}`))
  law.text = `<p class="law"><b>${place.join(", ")}.</b> ${plan.regions[codes[row]].html}. ${text}</p>`
  const lines = plan.series.map(({mark, name, key, texts, unit}) => {
    const value = fields.data[key][row]
    return line(mark, name, texts.length ? texts[value] : Number.isFinite(value) ? number(value) + unit : "–")
  })
  numbers.text = `<table class="numbers">${[...parameters(), ...lines].join("")}</table>`
}

const here = row_at(at, 0)
if (cb_obj.type != "Span" && axes.length > 1) show_map()
slices.forEach(([points, lines, ruler, range], axis) => {
  range.min_interval = shown < 0 ? plan.least : plan.series[shown].least
  show_slice(axis, points, lines)
  ruler.axis_label = shown < 0 ? plan.short : plan.series[shown].short
})
legend.text = shown < 0 ? plan.legend : plan.series[shown].legend
show_motion(here)
show_numbers(here)
