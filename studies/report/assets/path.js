/* The path that the reader gave, where there is one. */
function ownPath() {
  if (!data.path) return;
  document.querySelectorAll(".optional[href='#path'], #path").forEach((part) => part.classList.add("present"));
  element("path-name").textContent = data.path.name;
  element("path-text").textContent = data.path.text;
  show("path-figure", new Markup(data.path.figure));
}
