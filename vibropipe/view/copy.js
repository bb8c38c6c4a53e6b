// Copies a text; a link is the address of this page with the point.
let text = copies.data[what][0]
if (what == "link") {
  const address = new URL(location.href)
  const kept = address.searchParams.get("bokeh-session-id")
  address.search = text
  if (kept != null) address.searchParams.set("bokeh-session-id", kept)
  text = address.href
}
const ask = () => window.prompt("Copy:", text)
if (navigator.clipboard == null) ask()
else navigator.clipboard.writeText(text).catch(ask)
