// Moves the crosshair to the row nearest to the pointer, unless a tool has the drag.
const near = (values, at) => {
  let best = values[0]
  for (const value of values) if (Math.abs(value - at) < Math.abs(best - at)) best = value
  return best
}
const is_taken = cb_obj.event_name == "pan" && plot.toolbar.gestures?.pan?.active != null
const {x: [x], y: [y]} = crosshair.data
const next = [moves == "y" ? x : near(x_axis.data.at, cb_obj.x), moves == "x" ? y : near(y_axis.data.at, cb_obj.y)]
if (!is_taken && (next[0] != x || next[1] != y)) crosshair.data = {x: [next[0]], y: [next[1]]}
