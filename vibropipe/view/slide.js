// Keeps a slider and its field together. While the slider moves, the field takes its value ten times a second at most,
// always the newest one at the end; a value typed beyond the slider's ends moves them.
if (cb_obj == slider) {
  slider.waiting ??= setTimeout(() => {
    slider.waiting = null
    if (slider.value == slider.sent) return
    slider.sent = Number(slider.value.toPrecision(12))
    field.value = slider.sent
  }, 100)
} else if (field.value != null && field.value != slider.sent) {
  const value = field.value
  slider.sent = value
  slider.setv({start: Math.min(slider.start, value), end: Math.max(slider.end, value), value})
}
