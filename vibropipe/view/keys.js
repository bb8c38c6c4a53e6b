// Arrow keys move the crosshair by one row, with Shift by ten.
const STEPS = {ArrowLeft: [x_axis, "x", -1], ArrowRight: [x_axis, "x", 1],
               ArrowDown: [y_axis, "y", -1], ArrowUp: [y_axis, "y", 1]}
document.addEventListener("keydown", (event) => {
  const typed_into = event.composedPath()[0].tagName
  const step = STEPS[event.key]
  if (step == null || ["INPUT", "SELECT", "TEXTAREA"].includes(typed_into)) return
  const [axis, name, way] = step
  const values = Array.from(axis.data.at)
  if (values.length == 0) return
  event.preventDefault()
  const next = values.indexOf(crosshair.data[name][0]) + way * (event.shiftKey ? 10 : 1)
  const place = values[Math.min(Math.max(next, 0), values.length - 1)]
  if (place != crosshair.data[name][0]) crosshair.data = {...crosshair.data, [name]: [place]}
})
