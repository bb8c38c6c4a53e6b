// Moves the crosshair to the row nearest to the pointer, unless a tool has the drag.
const near = (values, at) => {
  let best = values[0]
  for (const value of values) if (Math.abs(value - at) < Math.abs(best - at)) best = value
  return best
}
const is_taken = cb_obj.event_name == "pan" && plot.toolbar.gestures?.pan?.active != null
if (!is_taken) {
  if (moves != "y") upright.location = near(x_axis.data.at, cb_obj.x)
  if (moves != "x") across.location = near(y_axis.data.at, cb_obj.y)
}
