// The task: what is due of it, and for each conjunct its automaton. Where it may be is filled, what
// is accepting has a ring, and the edge by which it came there is thick. What the plan drops is
// told, and read on.

import { byId, html, svg } from "./dom.js";
import { RADIUS, head, onCircle } from "./large_automata.js";
import { Zoom } from "./zoom.js";

const MOST_IN_A_ROW = 7, LEAST_SCALE = 0.75; // a row is scaled down to its box so far, and then scrolls
const CHARACTER_PX = 6.7, MOST_CHARACTERS = 26; // of a label
const LEAST_GAP_PX = 52, SIDE_PX = 26, LOOP_PX = 46, ARC_PX = 26;
const BESIDE_LOOP_PX = 18; // from the middle of a state to a label beside its loop
const INSET_PX = 6, CORNER_PX = 8; // of detours: from the middle of a state, and their round corners

export class TaskView {
  show(state) {
    if (this.drawn !== state.touched.automata) {
      this.drawn = state.touched.automata;
      this.rows = state.automata.map(drawn);
      byId("automata").replaceChildren(...this.rows.map((row) => row.element));
    }
    const version = ["automata", "states", "dropped", "taken up", "end"].map((kind) => state.touched[kind]).join();
    if (this.told === version) return;
    this.told = version;
    drawDue(state);
    this.rows?.forEach((row, i) => {
      const here = state.states[i] ?? [], taken = (state.taken[i] ?? []).map(String);
      row.nodes.forEach((node, n) => node.toggleAttribute("data-here", here.includes(n)));
      row.isAt(here, taken);
      for (const [edge, arrow] of row.arrows) arrow.toggleAttribute("data-taken", taken.includes(edge));
      row.element.toggleAttribute("data-violated", !here.length);
      row.element.toggleAttribute("data-dropped", state.dropped.has(row.conjunct));
    });
  }
}

function drawDue({ due, ending, automata }) {
  const isOver = ending || !automata.length;
  const nothing = ending ? "the flight is over" : automata.length ? "nothing at present" : "no task";
  byId("due").replaceChildren(...(isOver || !due.length
    ? [html("li", { class: "quiet" }, nothing)]
    : due.map(([line, words]) => html("li", {}, html("span", { class: "quiet" }, `${line} `), words))));
}

function drawn(automaton) {
  const { conjunct, formula, accepting } = automaton;
  const isRow = accepting.length <= MOST_IN_A_ROW;
  const { width, height, nodes, arrows, drawn, list, isAt } = isRow ? inRow(automaton) : onCircle(automaton, words, short);
  const drawing = svg("svg", {
    viewBox: `0 0 ${width} ${height}`, width, height, class: isRow ? "automaton" : "automaton large", role: isRow ? "img" : "group",
    "aria-label": `automaton of ${conjunct}, ${accepting.length} states`,
  }, ...drawn, ...nodes);
  if (isRow) drawing.style.minWidth = `${LEAST_SCALE * width}px`;
  const box = isRow ? html("div", { class: "drawing", tabindex: "0", role: "group", "aria-label": `automaton of ${conjunct}` }, drawing)
    : zoomable(drawing, conjunct, nodes);
  const element = html("div", { class: "conjunct" },
    html("strong", {}, conjunct),
    html("span", { class: "verdict" }, " violated"), html("span", { class: "left-out" }, " dropped"),
    html("code", {}, formula), box, list);
  return { element, nodes, conjunct, arrows, isAt };
}

// A large one is seen whole, or a part of it; a state that gets the focus comes into sight.
function zoomable(drawing, conjunct, nodes) {
  const whole = html("button", { type: "button", class: "whole", hidden: "" }, "Whole automaton");
  const box = html("div", {
    class: "drawing zoomable", tabindex: "0", role: "group", "aria-keyshortcuts": "+ - 0",
    "aria-label": `automaton of ${conjunct}: + and - zoom, arrows move, 0 shows all of it`,
  }, drawing, whole);
  const { width, height } = drawing.viewBox.baseVal;
  const zoom = new Zoom(box, whole, () => {
    const { left, top, width: share } = zoom.view;
    drawing.setAttribute("viewBox", [left * width, top * height, share * width, share * height].join(" "));
  });
  for (const node of nodes) {
    node.addEventListener("focus", () => {
      const { e, f } = node.transform.baseVal[0].matrix;
      if (!zoom.isWhole) zoom.centre([e / width, f / height]);
    });
  }
  return box;
}

function inRow({ initial, accepting, arrows }) {
  const plan = laidOut(accepting.length, arrows), { x, y, width, height } = plan;
  const nodes = accepting.map((is, n) => svg("g", { class: "state", transform: `translate(${x[n]} ${y})` },
    svg("circle", { r: RADIUS }), ...(is ? [svg("circle", { r: RADIUS + 3, class: "ring" })] : []),
    svg("text", { y: 4 }, String(n)), svg("title", {}, is ? "accepting" : "not accepting")));
  const edges = plan.arrows.map(({ edge, d, label, at: [left, top] }) => [String(edge), svg("g", { class: "arrow" },
    svg("path", { d }), svg("text", { x: left, y: top }, short(label)), svg("title", {}, label))]);
  const entries = initial.map((n) => svg("g", { class: "arrow" }, svg("path", {
    d: `M${x[n] - SIDE_PX} ${y - 16}L${x[n] - 11} ${y - 10}${head([x[n] - 11, y - 10], 0.93, 0.37)}` })));
  return { width, height, nodes, arrows: edges, drawn: [...entries, ...edges.map(([, arrow]) => arrow)], list: "", isAt() {} };
}

// As people say it: at(A) is A.
const words = (label) => label.replace(/\bat\((\w+)\)/g, "$1");
const short = (label) => {
  const text = words(label);
  return text.length > MOST_CHARACTERS ? `${text.slice(0, MOST_CHARACTERS - 1)}…` : text;
};
const wide = (label) => short(label).length * CHARACTER_PX;

// States in a row. Onwards to the next one above the middle, back to the last one below it, to itself
// a loop on top; further ones below, down, along and up, each at a depth of its own. A label stands at
// its edge, where no other edge passes.
function laidOut(count, arrows) {
  const span = ([from, to]) => to - from;
  const labels = (isOne) => arrows.filter(isOne).map(([, , label]) => wide(label));
  const loop = (n) => Math.max(0, ...labels(([from, to]) => from === n && to === n));
  const x = [SIDE_PX + Math.max(RADIUS, loop(0) / 2 - 10)];
  for (let n = 1; n < count; n += 1) {
    const between = Math.max(0, ...labels(([from, to]) => Math.min(from, to) === n - 1 && Math.max(from, to) === n));
    x.push(x[n - 1] + Math.max(LEAST_GAP_PX, between + 2 * BESIDE_LOOP_PX, (loop(n - 1) + loop(n)) / 2 + 10));
  }
  const far = arrows.filter((each) => Math.abs(span(each)) > 1).sort((a, b) => Math.abs(span(a)) - Math.abs(span(b)));
  const hasLoops = arrows.some((each) => !span(each)), isBack = arrows.some((each) => span(each) === -1);
  const y = RADIUS + (hasLoops ? LOOP_PX : ARC_PX);
  const width = Math.max(x.at(-1) + Math.max(SIDE_PX, loop(count - 1) / 2 + 4), ...far.map(([from, to, label]) =>
    (x[from] + x[to] + wide(label)) / 2 + 4));
  const depth = (each) => ARC_PX * (far.indexOf(each) + 1 + (isBack ? 1 : 0));
  // Where a label on a detour meets none of the deeper ones, which pass on their way down and up.
  const free = (each) => {
    const [from, to, label] = each, half = wide(label) / 2 + INSET_PX;
    const passing = far.slice(far.indexOf(each) + 1).flatMap(([a, b]) => [x[a], x[b]]);
    const between = x.slice(1).map((right, n) => (x[n] + right) / 2);
    const [low, high] = [x[from], x[to]].sort((a, b) => a - b), middle = (low + high) / 2;
    const spots = [middle, ...between.filter((spot) => spot > low && spot < high)];
    return spots.find((spot) => passing.every((other) => Math.abs(other - spot) > half)) ?? middle;
  };
  return {
    x, y, width, height: y + RADIUS + 16 + ARC_PX * (far.length + (isBack ? 1 : 0)),
    arrows: arrows.map((each) => {
      const [from, to, label] = each, edge = [from, to], middle = (x[from] + x[to]) / 2;
      if (from === to) return { edge, label, d: looped(x[from], y - RADIUS - 3), at: [x[from], y - RADIUS - 26] };
      if (span(each) === 1) return { edge, label, d: arc(x[from], x[to], y, -1, 12), at: [middle, y - RADIUS - 11] };
      if (span(each) === -1) return { edge, label, d: arc(x[from], x[to], y, 1, 12), at: [middle, y + RADIUS + 17] };
      const deep = y + RADIUS + depth(each);
      return { edge, label, d: detour(x[from], x[to], y + RADIUS - 1, deep), at: [free(each), deep + 13] };
    }),
  };
}

const looped = (x, top) => `M${x - 5} ${top + 1}c-10-24 20-24 10 0${head([x + 5, top + 1], -0.38, 0.92)}`;

// From one state to another, down to a depth and up again; onwards and back are beside each other.
function detour(from, to, y, deep) {
  const towards = Math.sign(to - from), inset = towards > 0 ? INSET_PX / 3 : INSET_PX;
  const [a, b] = [from + towards * inset, to - towards * inset], turn = towards * CORNER_PX;
  return `M${a} ${y}V${deep - CORNER_PX}Q${a} ${deep} ${a + turn} ${deep}H${b - turn}Q${b} ${deep} ${b} ${deep - CORNER_PX}V${y}${head([b, y], 0, -1)}`;
}

// From one state to another, above (-1) or below (1) the row; it ends in a small head.
function arc(from, to, y, side, bend) {
  const towards = Math.sign(to - from), slant = 8;
  const [a, b] = [from + towards * slant, to - towards * slant];
  const start = y + side * (RADIUS - 1), turn = y + side * (RADIUS + bend);
  const middle = (a + b) / 2, steep = Math.hypot(b - middle, start - turn) || 1;
  return `M${a} ${start}Q${middle} ${turn} ${b} ${start}${head([b, start], (b - middle) / steep, (start - turn) / steep)}`;
}
