// Texts have a size of their own: a new one moves nothing, but Bokeh would lay out and draw the whole page again.
for (const text of texts) {
  const view = Bokeh.index.find_one(text)
  if (view != null) view.compute_layout = () => {}
}
