// Arrow keys move the crosshair by one row, with Shift by ten.
const STEPS = {ArrowLeft: [x_axis, upright, -1], ArrowRight: [x_axis, upright, 1],
               ArrowDown: [y_axis, across, -1], ArrowUp: [y_axis, across, 1]}
document.addEventListener("keydown", (event) => {
  const typed_into = event.composedPath()[0].tagName
  const step = STEPS[event.key]
  if (step == null || ["INPUT", "SELECT", "TEXTAREA"].includes(typed_into)) return
  const [axis, span, way] = step
  const values = Array.from(axis.data.at)
  if (values.length == 0) return
  event.preventDefault()
  const next = values.indexOf(span.location) + way * (event.shiftKey ? 10 : 1)
  span.location = values[Math.min(Math.max(next, 0), values.length - 1)]
})
