// The plan, the beliefs and the vehicle's figures.

import { byId, html, say, statusShape } from "./dom.js";
import { actionsOf } from "./tree.js";

const LOW_PERCENT = 25;

export class PlanView {
  show(state) {
    const version = `${state.touched.tree} ${state.touched.status} ${state.touched.withdrawn} ` +
      `${state.touched.restored} ${state.touched.event}`;
    if (version === this.version) return;
    this.version = version;
    const actions = actionsOf(state);
    drawPlan(state, actions);
    drawBeliefs(state, actions);
  }
}

function drawPlan(state, actions) {
  const number = state.plan?.plan && state.plan.number;
  byId("plan-title").textContent = state.plan?.type === "WrittenTreeAdopted"
    ? "Actions of the mission's own tree"
    : number ? `Plan ${number + 1}, after replan ${number}` : "Plan";
  const steps = (list) => list.map(({ name, status }) => html(
    "li", { class: "step", "data-status": status, "aria-current": status === "RUNNING" && "step" },
    statusShape(status), name));
  const prefix = html("ol", { class: "prefix" }, ...steps(actions.filter((a) => !a.isInLoop)));
  const loop = actions.filter((a) => a.isInLoop);
  const parts = [prefix];
  if (loop.length) {
    parts.push(html("div", { class: "loop" },
      html("ol", { "aria-label": "loop, for ever" }, ...steps(loop)),
      html("span", { class: "omega", tabindex: "0", role: "note", "data-explain": "omega", "aria-describedby": "tip" }, "ω")));
  }
  if (!state.nodes.length) parts.push(html("p", { class: "quiet" }, "no plan yet"));
  const reason = state.plan?.reason;
  if (reason) parts.unshift(html("p", { class: "reason" }, reason));
  byId("plan").replaceChildren(...parts);
}

function drawBeliefs(state, actions) {
  const held = new Set(actions.flatMap((action) => action.assumes));
  for (const belief of state.withdrawn) held.delete(belief);
  const chip = (kind, status, text, title) =>
    html("li", { class: `chip ${kind}`, title }, statusShape(status), text);
  const facts = [...state.facts].map(([event, holds]) =>
    chip(holds ? "holds" : "over", holds ? "RUNNING" : "INVALID", event,
      holds ? "this event holds" : "this event holds no more"));
  const chips = [
    ...[...state.withdrawn].map((b) => chip("withdrawn", "FAILURE", b, "withdrawn: it has failed")),
    ...facts,
    ...[...held].sort().map((b) => chip("held", "SUCCESS", b, "held: the plan relies on it")),
  ];
  byId("beliefs").replaceChildren(chips.length
    ? html("ul", { class: "chips" }, ...chips)
    : html("p", { class: "quiet" }, "none yet"));
}

export function showVehicle(vehicle, state) {
  say(byId("phase"), state.ending ? state.ending.text.split("\n")[0] : state.phase);
  if (!vehicle) return;
  const { battery_percent: percent, voltage_v, link_age_s: age_s } = vehicle;
  figure("mode", vehicle.mode + (vehicle.armed ? "" : ", disarmed"));
  figure("battery", battery(percent, voltage_v), percent !== null && percent < LOW_PERCENT);
  figure("link", age_s < 0.5 ? "good" : `silent for ${age_s.toFixed(1)} s`, age_s >= 0.5);
  figure("speed", `${vehicle.speed_mps.toFixed(1)} m/s`);
  figure("up", `${vehicle.enu[2].toFixed(1)} m`);
}

// What is known of it.
function battery(percent, voltage_v) {
  const known = [percent === null ? [] : `${percent} %`, voltage_v === null ? [] : `${voltage_v.toFixed(1)} V`].flat();
  return known.join(", ") || "unknown";
}

function figure(name, value, isBad = false) {
  const element = byId(name);
  say(element, value);
  element.classList.toggle("bad", isBad);
}
