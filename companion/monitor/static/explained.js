// What signs and words of the page mean, told when the pointer is over them or they have the focus.

import { byId, html, statusShape } from "./dom.js";

const MEANINGS = {
  sequence: "→ Sequence: its children one after the other, until one fails.",
  fallback: "? Fallback: the next child only where the one before fails. An action is one: its triple, and where that fails, a belief is withdrawn.",
  parallel: "⇉ Parallel: its children at the same time.",
  loop: "↻ L: the lap of the plan, again and again, for ever.",
  decorator: "◇ Decorator: changes what its only child says, as MAX_TRY and not do.",
  triple: "triple: precondition, skill, effect. The skill begins where its precondition (pre) holds, and is done where its effect (eff) holds.",
  tries: "MAX_TRY(n): tries its child up to n times before it fails.",
  not: "not: fails where its child succeeds. So an action has failed also after its belief was withdrawn, and a new plan is made.",
  predicted: "as predicted? Fails as soon as an event differs from what the plan assumes. Then a new plan is made.",
  parameter: "update_param: chooses the waypoint in the region of the place, as late as possible.",
  command: "The command of the skill: what the vehicle does now.",
  pre: "pre: what has to hold before the skill begins.",
  eff: "eff: what has to hold when the skill is done.",
  withdraw: "withdraw: gives up what the plan relied on, because the skill has failed.",
  omega: "ω: this part of the plan is flown for ever, lap after lap.",
  RUNNING: "Running: under way.", SUCCESS: "Success: done, or it holds.",
  FAILURE: "Failure: it has failed, or does not hold.", INVALID: "Idle: not begun, or left.",
};
const SIGNS = [
  ["sequence", "→"], ["fallback", "?"], ["loop", "↻ L"], ["decorator", "◇"], ["triple", "triple"],
  ["tries", "MAX_TRY"], ["omega", "ω"],
];
const TYPES = {
  sequence: "sequence", reactive_sequence: "sequence", subtree: "sequence", selector: "fallback", action: "fallback",
  parallel: "parallel", repeat: "loop", retry: "tries", inverter: "not", timeout: "decorator",
};
const NAMES = [
  [/^triple$/, "triple"], [/^pre /, "pre"], [/^eff /, "eff"], [/^as (predicted|at first)\?$/, "predicted"],
  [/^update_param /, "parameter"], [/^withdraw /, "withdraw"],
];
const GAP_PX = 6;

// The key of what a node of the tree means.
export const meaningOf = ({ type, name }) =>
  NAMES.find(([pattern]) => pattern.test(name))?.[1] ?? TYPES[type] ?? "command";

// Draws the legend of the tree, and tells meanings from now on.
export function explain() {
  const word = (key, ...shown) => html("li", {}, html("button",
    { type: "button", class: "word", "data-explain": key, "aria-describedby": "tip" }, ...shown));
  const statuses = ["RUNNING", "SUCCESS", "FAILURE", "INVALID"];
  byId("signs").replaceChildren(
    ...SIGNS.map(([key, sign]) => word(key, sign)), ...statuses.map((status) => word(status, statusShape(status))));
  for (const [event, take] of [["pointerover", tell], ["focusin", tell], ["pointerout", hide], ["focusout", hide]]) {
    document.addEventListener(event, take);
  }
  document.addEventListener("scroll", hide, true);
  document.addEventListener("keydown", ({ key }) => { if (key === "Escape") hide(); });
}

function tell({ target }) {
  const about = target.closest?.("[data-explain]"), tip = byId("tip");
  if (!about) return;
  tip.textContent = MEANINGS[about.dataset.explain];
  tip.hidden = false;
  const { left, top, bottom } = about.getBoundingClientRect();
  const { width, height } = tip.getBoundingClientRect();
  const isBelow = bottom + GAP_PX + height < innerHeight;
  tip.style.left = `${Math.max(GAP_PX, Math.min(left, innerWidth - width - GAP_PX))}px`;
  tip.style.top = `${isBelow ? bottom + GAP_PX : top - GAP_PX - height}px`;
}

function hide() {
  byId("tip").hidden = true;
}
