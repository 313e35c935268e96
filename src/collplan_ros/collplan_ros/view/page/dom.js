// Elements of the page. Text that came over the network is only ever set as text.

/** The element with an id. */
export const byId = (id) => document.getElementById(id);

/** A new element at the end of another. */
export function element(name, parent, className = "", text = "") {
  const made = document.createElement(name);
  if (className) made.className = className;
  if (text) made.textContent = text;
  parent.append(made);
  return made;
}

/** What was kept in this browser under a name; null where it keeps nothing. */
export function kept(name) {
  try {
    return JSON.parse(localStorage.getItem(`collplan.${name}`));
  } catch {
    return null;
  }
}

/** Keeps a value in this browser, where it lets one. */
export function keep(name, value) {
  try {
    localStorage.setItem(`collplan.${name}`, JSON.stringify(value));
  } catch {
    // a page of a file, or a browser that keeps nothing
  }
}
