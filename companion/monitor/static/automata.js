// The task: for each conjunct its automaton. Where it may be is filled, what is accepting has a ring.
// What the plan drops is told, and read on.

import { byId, html, svg } from "./dom.js";

const GAP = 44, RADIUS = 7, HEIGHT = 52, MOST_DRAWN = 7;

export class TaskView {
  show(state) {
    if (this.drawn !== state.touched.automata) {
      this.drawn = state.touched.automata;
      this.rows = state.automata.map(drawn);
      byId("automata").replaceChildren(...this.rows.map((row) => row.element));
    }
    const version = ["automata", "states", "dropped", "taken up"].map((kind) => state.touched[kind]).join();
    if (this.told === version) return;
    this.told = version;
    this.rows?.forEach((row, i) => {
      const here = state.states[i] ?? [];
      row.nodes.forEach((node, n) => node.toggleAttribute("data-here", here.includes(n)));
      row.element.toggleAttribute("data-violated", !here.length);
      row.element.toggleAttribute("data-dropped", state.dropped.has(row.conjunct));
    });
  }
}

function drawn({ conjunct, formula, accepting, arrows }) {
  const isSmall = accepting.length <= MOST_DRAWN;
  const step = isSmall ? GAP : 2.9 * RADIUS;
  const x = (n) => 16 + n * step, y = HEIGHT / 2;
  const nodes = accepting.map((is, n) => svg("g", { class: "state", transform: `translate(${x(n)} ${y})` },
    svg("circle", { r: arrows.some(([, to]) => to === n) ? RADIUS : 3 }), ...(is ? [svg("circle", { r: RADIUS + 3, class: "ring" })] : []),
    svg("title", {}, is ? "accepting" : "not accepting")));
  const lines = isSmall ? arrows.map(([from, to, label]) =>
    svg("path", { d: arrow(x, y, from, to), class: "arrow" }, svg("title", {}, label))) : [];
  const width = x(accepting.length - 1) + 16;
  const drawing = svg("svg", {
    viewBox: `0 0 ${width} ${HEIGHT}`, width, height: HEIGHT, class: "automaton",
    role: "img", "aria-label": `automaton of ${conjunct}, ${accepting.length} states`,
  }, ...lines, ...nodes);
  const element = html("div", { class: "conjunct" },
    html("div", { class: "says" }, html("strong", {}, conjunct),
      html("span", { class: "verdict" }, " violated"), html("span", { class: "left-out" }, " dropped"),
      html("code", { title: formula }, formula)),
    drawing);
  return { element, nodes, conjunct };
}

// Onwards above the middle, back below it, to itself a loop on top; each ends in a small head.
function arrow(x, y, from, to) {
  const r = RADIUS + 3;
  if (from === to) {
    const [a, top] = [x(from), y - r];
    return `M${a - 4} ${top + 1}c-7-15 15-15 8 0${head(a + 4, top + 1, 0.2, 1)}`;
  }
  const side = to > from ? -1 : 1;
  const [a, b] = [x(from) - side * 5, x(to) + side * 5];
  const [start, bend] = [y + side * (r - 2), y + side * Math.min(24, 10 + 6 * Math.abs(to - from))];
  return `M${a} ${start}Q${(a + b) / 2} ${bend} ${b} ${start}${head(b, start, -side * 0.8, -side * 0.6)}`;
}

function head(x, y, dx, dy) {
  const [bx, by] = [x - 4 * dx, y - 4 * dy];
  return `M${bx - 2.5 * dy} ${by + 2.5 * dx}L${x} ${y} ${bx + 2.5 * dy} ${by - 2.5 * dx}`;
}
