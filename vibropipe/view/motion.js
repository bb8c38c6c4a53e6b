// The motion between stored impacts in closed form: the response to the force, and a damped free motion from each event.
// p: nu, f, h, upper, lower, R1, R2. Each event is [time, velocity before, support], or of a rest
// [start, end, minus support]; times in tau, in order. An orbit of a length goes on from its last event, that of the
// turn before; a motion without an orbit (length 0) begins at its first event. Returns time, x, v with breaks at jumps.
const forced = (p, t) => {
  const c = (1 - p.nu) * (1 + p.nu), d = p.h * p.nu, size = c * c + d * d
  const sine = Math.sin(p.nu * t), cosine = Math.cos(p.nu * t)
  if (p.f == 0) return [0, 0]
  if (size == 0) return [-0.5 * p.f * t * cosine, -0.5 * p.f * (cosine - t * sine)]
  return [p.f / size * (c * sine - d * cosine), p.f / size * p.nu * (c * cosine + d * sine)]
}

const flight = (p, from, t) => {
  const b = 0.5 * p.h, square = (1 - b) * (1 + b), w = Math.sqrt(Math.abs(square)), s = t - from.time
  const [x0, v0] = forced(p, from.time), [x, v] = forced(p, t)
  const z = from.x - x0, u = from.v - v0, decay = Math.exp(-b * s)
  const [C, S] = square > 0 ? [Math.cos(w * s), Math.sin(w * s) / w]
    : square < 0 ? [Math.cosh(w * s), Math.sinh(w * s) / w] : [1, s]
  return [x + decay * (z * (C + b * S) + u * S), v + decay * (u * (C - b * S) - z * S)]
}

const wall = (p, side) => (Math.abs(side) == 1 ? p.upper : p.lower)

const after = (p, [time, velocity, side], shift) => side > 0
  ? {time: time + shift, x: wall(p, side), v: -(side == 1 ? p.R1 : p.R2) * velocity, until: -Infinity}
  : {time: velocity + shift, x: wall(p, side), v: 0, until: velocity + shift}

const rebuild = (p, events, length, samples) => {
  const found = {time: [], x: [], v: []}
  const put = (time, x, v) => { found.time.push(time); found.x.push(x); found.v.push(v) }
  const end = length > 0 ? length : events.length ? events[events.length - 1][0] : 0
  const begin = length > 0 ? 0 : events.length ? events[0][0] : 0
  const step = 2 * Math.PI / p.nu / samples
  let from = events.length && length > 0 ? after(p, events[events.length - 1], -length) : null
  if (!events.length) {
    const [x, v] = forced(p, 0)
    from = {time: 0, x, v, until: -Infinity}
  }
  const at = (t) => (t < from.until ? [from.x, 0] : flight(p, from, t))
  let n = 0
  for (const event of [...events, null]) {
    const stop = event == null ? end : event[0]
    for (; from != null && begin + n * step < stop - 1e-9; n++) put(begin + n * step, ...at(begin + n * step))
    while (begin + n * step <= stop + 1e-9) n++
    if (event == null) {
      if (from != null && length > 0) put(end, ...at(end))
      break
    }
    const [time, velocity, side] = event
    const next = after(p, event, 0)
    if (side > 0) {
      put(time, next.x, velocity)
      put(time, NaN, NaN)
    }
    put(time, next.x, next.v)
    from = next
  }
  return found
}
