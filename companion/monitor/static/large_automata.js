// An automaton with too many states for a row: they stand on a circle, with all edges between them.
// An edge has its label under the pointer, and in the list below. That tells the edges just taken, and
// those of a state: of the one that the pointer or the keyboard is on, else of those where the
// automaton may be.

import { html, svg } from "./dom.js";

export const RADIUS = 12;
const GAP_PX = 46, SIDE_PX = 58, BEND = 0.16, LOOP_PX = 26;
const BESIDE_LOOP = 1; // radians

export function onCircle({ initial, accepting, arrows }, words, short) {
  const turn = (2 * Math.PI) / accepting.length;
  const around = Math.max(80, GAP_PX / turn), size = 2 * (around + SIDE_PX);
  const spot = (n, distance = around) =>
    [size / 2 + distance * Math.sin(n * turn), size / 2 - distance * Math.cos(n * turn)];
  const places = accepting.map((_, n) => spot(n));
  const edges = arrows.map(([from, to, label]) => {
    const isLoop = from === to;
    const { d, at: [x, y] } = isLoop ? loop(places[from], spot(from, around + LOOP_PX)) : bow(places[from], places[to]);
    const arrow = svg("g", { class: "arrow" }, svg("path", { d }), svg("text", { x, y }, short(label)), svg("title", {}, label));
    return { from, to, label, arrow };
  });
  const nodes = accepting.map((is, n) => svg("g", {
    class: "state", transform: `translate(${places[n]})`, tabindex: "0", role: "img",
    "aria-label": `state ${n}, ${is ? "accepting" : "not accepting"}`,
  }, svg("circle", { r: RADIUS }), ...(is ? [svg("circle", { r: RADIUS + 3, class: "ring" })] : []), svg("text", { y: 4 }, String(n))));
  const entries = initial.map((n) => svg("g", { class: "arrow entry" },
    svg("path", { d: entry(places[n], n * turn - BESIDE_LOOP) })));
  const list = html("ul", { class: "edges" });
  const shown = { here: [], taken: [], chosen: null };
  const item = ({ from, to, label }, isTaken) => html("li", { class: isTaken ? "taken" : "" },
    html("strong", {}, `${from} → ${to} `), words(label), ...(isTaken ? [" (taken)"] : []));
  const tell = () => {
    const from = shown.chosen === null ? shown.here : [shown.chosen];
    edges.forEach((edge) => edge.arrow.toggleAttribute("data-told", from.includes(edge.from)));
    const isTaken = ({ from, to }) => shown.taken.includes(String([from, to]));
    list.replaceChildren(
      ...edges.filter(isTaken).map((edge) => item(edge, true)),
      ...edges.filter((edge) => from.includes(edge.from) && !isTaken(edge)).map((edge) => item(edge, false)));
  };
  const choose = (n) => { shown.chosen = n; tell(); };
  nodes.forEach((node, n) => {
    for (const kind of ["pointerenter", "focus"]) node.addEventListener(kind, () => choose(n));
    for (const kind of ["pointerleave", "blur"]) node.addEventListener(kind, () => choose(null));
  });
  return {
    width: size, height: size, nodes, list, drawn: [...entries, ...edges.map((edge) => edge.arrow)],
    arrows: edges.map(({ from, to, arrow }) => [String([from, to]), arrow]),
    isAt(here, taken) { Object.assign(shown, { here, taken }); tell(); },
  };
}

// Bent to its left, so that there and back are two.
function bow([ax, ay], [bx, by]) {
  const turn = [(ax + bx) / 2 + BEND * (by - ay), (ay + by) / 2 - BEND * (bx - ax)];
  const start = towards([ax, ay], turn, RADIUS), end = towards([bx, by], turn, RADIUS + 3);
  return { d: `M${start}Q${turn} ${end}${headed(turn, end)}`, at: [(ax + bx + 2 * turn[0]) / 4, (ay + by + 2 * turn[1]) / 4 + 4] };
}

function loop([x, y], [outX, outY]) {
  const [dx, dy] = [outX - x, outY - y];
  const [one, other] = [1, -1].map((side) => [outX + 0.3 * dx - (side * dy) / 2, outY + 0.3 * dy + (side * dx) / 2]);
  const start = towards([x, y], one, RADIUS), end = towards([x, y], other, RADIUS + 3);
  return { d: `M${start}C${one} ${other} ${end}${headed(other, end)}`, at: [outX + 0.4 * dx, outY + 0.4 * dy] };
}

// An arrow from nowhere, out of a direction that is clockwise from north.
function entry([x, y], direction) {
  const [start, end] = [2.7, 1.35].map((times) =>
    [x + times * RADIUS * Math.sin(direction), y - times * RADIUS * Math.cos(direction)]);
  return `M${start}L${end}${headed(start, end)}`;
}

function towards([ax, ay], [bx, by], distance) {
  const length = Math.hypot(bx - ax, by - ay);
  return [ax + ((bx - ax) * distance) / length, ay + ((by - ay) * distance) / length];
}

function headed([fromX, fromY], [x, y]) {
  const length = Math.hypot(x - fromX, y - fromY);
  return head([x, y], (x - fromX) / length, (y - fromY) / length);
}

// The head of an arrow that ends there, in a direction of length 1.
export function head([x, y], dx, dy) {
  const [bx, by] = [x - 6 * dx, y - 6 * dy];
  return `M${bx - 3 * dy} ${by + 3 * dx}L${x} ${y} ${bx + 3 * dy} ${by - 3 * dx}`;
}
