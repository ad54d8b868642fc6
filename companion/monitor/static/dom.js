// Elements in one call, and the shapes that stand for a status: each has its own form, not only
// its own colour.

export const byId = (id) => document.getElementById(id);

// Sets a text that has changed; to set an equal one would cost a new layout.
export function say(element, text) {
  if (element.textContent !== text) element.textContent = text;
}

export function html(tag, attributes = {}, ...children) {
  return filled(document.createElement(tag), attributes, children);
}

export function svg(tag, attributes = {}, ...children) {
  return filled(document.createElementNS("http://www.w3.org/2000/svg", tag), attributes, children);
}

function filled(element, attributes, children) {
  for (const [name, value] of Object.entries(attributes)) {
    if (name.startsWith("on")) element.addEventListener(name.slice(2), value);
    else if (value !== null && value !== false) element.setAttribute(name, value);
  }
  element.append(...children);
  return element;
}

const SHAPES = {
  RUNNING: "M4 2.5 13 8 4 13.5Z",
  SUCCESS: "M2.5 8.5 6.5 12.5 13.5 4",
  FAILURE: "M3.5 3.5 12.5 12.5M12.5 3.5 3.5 12.5",
  INVALID: "M8 5.5A2.5 2.5 0 1 0 8 10.5 2.5 2.5 0 1 0 8 5.5Z",
};
const WORDS = { RUNNING: "running", SUCCESS: "success", FAILURE: "failure", INVALID: "idle" };

export function statusShape(status) {
  const shape = svg("svg", { viewBox: "0 0 16 16", class: "shape", role: "img" });
  shape.append(svg("title"), svg("path"));
  setStatus(shape, status);
  return shape;
}

export function setStatus(shape, status) {
  shape.dataset.status = status;
  shape.firstChild.textContent = WORDS[status];
  shape.lastChild.setAttribute("d", SHAPES[status]);
}

export function minutes(seconds) {
  const tenths = Math.max(0, Math.round(seconds * 10));
  const text = (number, width) => String(number).padStart(width, "0");
  return `${text(Math.floor(tenths / 600), 2)}:${text((tenths % 600) / 10 | 0, 2)}.${tenths % 10}`;
}
