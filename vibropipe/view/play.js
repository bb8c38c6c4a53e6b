// Plays the motion on the drawing, one forcing period in two seconds, and moves the dots along.
const button = cb_obj
button.label = button.active ? "■ stop" : "▶ play"
const start = performance.now()
const frame = (now) => {
  const {time, x, v} = motion.data
  const last = time.length - 1
  if (!button.active || last < 1) {
    dot.data = {time: [], x: [], v: []}
    return
  }
  const speed = motion.tags.length ? motion.tags[0] / 2000 : time[last] / 4000
  const at = ((now - start) * speed) % time[last]
  let low = 0, high = last
  while (high - low > 1) {
    const middle = (low + high) >> 1
    if (time[middle] <= at) low = middle
    else high = middle
  }
  const share = time[high] > time[low] ? (at - time[low]) / (time[high] - time[low]) : 0
  const between = (values) => values[low] + share * (values[high] - values[low])
  const place = between(x)
  if (Number.isFinite(place)) {
    dot.data = {time: [at], x: [place], v: [between(v)]}
    mass.data = {...mass.data, x: [place]}
    const n = spring.data.x.length
    const left = spring.data.x[0]
    spring.data = {x: Array.from({length: n}, (_, i) => left + (place - left) * i / (n - 1)), y: spring.data.y}
  }
  requestAnimationFrame(frame)
}
if (button.active) requestAnimationFrame(frame)
