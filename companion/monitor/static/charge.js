// The charge over time: measured, planned and required at each position, charges and replans. A plan
// is drawn at the times at which its positions were reached; what lies ahead, at those it expects.

import { byId, minutes, say, svg } from "./dom.js";

const HEIGHT_PX = 120;
const MARGIN = { left: 42, right: 10, top: 16, bottom: 18 };
const LEAST_LABEL_PX = 14; // between the numbers of two replans
const TIMES_PX = 90; // between two times on the axis
const STEPS_S = [5, 10, 15, 30, 60, 120, 300, 600, 900, 1800, 3600, 7200, 14400];
const OVER = new Set(["returning", "holding", "leaving the vehicle on hold", "landing"]);

export const freshCharge = () => ({
  measured: [], plans: [], ahead: [], pinned_s: 0, reserve: null, charging: [], replans: [], leaves: new Set(),
});

const charges = (node) => node.does === "charge";

// Takes an event of any kind into what is known of the charge.
export function applyCharge(charge, event) {
  const last = charge.charging.at(-1);
  const stop = () => { if (last && last.to === null) last.to = event.t_s; };
  const reach = (at) => {
    charge.plans.at(-1).push({ t_s: event.t_s, percent: at.percent, required: at.required_percent });
    charge.pinned_s = event.t_s;
  };
  const complete = (action) => { // those before it, of which nothing is told, were done before
    const place = charge.ahead.findIndex((each) => each.action === action);
    if (place >= 0) reach(charge.ahead.splice(0, place + 1).at(-1));
  };
  switch (event.kind) {
    case "battery":
      charge.measured.push({ t_s: event.t_s, percent: event.percent });
      break;
    case "charge":
      charge.plans.push([]);
      reach(event);
      charge.ahead = [...event.ahead];
      charge.reserve = event.reserve_percent;
      break;
    case "at":
    case "done":
      complete(event.action);
      break;
    case "replan":
      charge.replans.push({ t_s: event.t_s, label: event.plan ? String(event.number) : "×" });
      if (!event.plan) charge.ahead = [];
      break;
    case "tree":
      stop();
      charge.leaves = new Set(event.nodes.flatMap((node, i) => charges(node) ? [i] : []));
      break;
    case "status":
      for (const [number, status] of event.changed) {
        if (!charge.leaves.has(number)) continue;
        if (status !== "RUNNING") stop();
        else if (charge.charging.at(-1)?.to !== null) charge.charging.push({ from: event.t_s, to: null });
      }
      break;
    case "phase":
      if (event.type === "PhaseEntered" && OVER.has(event.phase)) charge.ahead = [];
      break;
    case "end":
      stop();
      charge.ahead = [];
      break;
  }
}

export class ChargeView {
  constructor(seek) {
    this.strip = byId("charge-strip");
    this.strip.onclick = (click) => {
      const { left } = this.strip.getBoundingClientRect();
      if (this.scale) seek(this.scale.time(click.clientX - left));
    };
    this.box = byId("charge");
    this.box.hidden = true;
    this.details = this.box.firstElementChild;
    this.details.open = this.wasOpened = false;
    this.looked = 0;
  }

  // Is the charge a matter of the mission? Then it opens, once, and is the reader's.
  look(events) {
    for (; this.looked < events.length; this.looked += 1) {
      const event = events[this.looked];
      if (event.kind !== "charge" && !event.nodes?.some(charges)) continue;
      this.box.hidden = false;
      if (!this.wasOpened) this.details.open = this.wasOpened = true;
    }
  }

  show(history, state) {
    this.look(history.events);
    if (this.box.hidden) return;
    const { charge, time_s } = state;
    say(byId("charge-said"), said(charge));
    if (!this.details.open) return;
    const width = this.strip.clientWidth;
    const scale = scaleOf(history, state, width);
    const version = [state.count, width, scale.end_s, Math.floor(time_s)].join();
    if (version !== this.version) {
      this.version = version;
      this.scale = scale;
      this.draw(history, state, scale);
    }
    const x = this.scale.x(time_s);
    this.now.setAttribute("x1", x);
    this.now.setAttribute("x2", x);
  }

  draw(history, state, scale) {
    const { charge, time_s } = state;
    const { x, y, top, bottom, width } = scale;
    this.strip.setAttribute("viewBox", `0 0 ${width} ${HEIGHT_PX}`);
    const upright = (t_s, name) => svg("line", { class: name, x1: x(t_s), x2: x(t_s), y1: top, y2: bottom });
    const level = (percent, name) => svg("line", {
      class: name, x1: MARGIN.left, x2: width - MARGIN.right, y1: y(percent), y2: y(percent) });
    this.now = upright(time_s, "now");
    const parts = [
      ...charge.charging.map(({ from, to }) => svg("rect", {
        class: "charging", x: x(from), y: top, width: Math.max(1, x(to ?? time_s) - x(from)), height: bottom - top })),
      ...scale.percents.flatMap((percent) => [level(percent, "grid"),
        svg("text", { class: "percent", x: MARGIN.left - 4, y: y(percent) + 4 }, `${percent} %`)]),
      ...scale.times.map((t_s) => svg("text", { class: "time", x: x(t_s), y: HEIGHT_PX - 4 }, minutes(t_s).slice(0, -2))),
      ...replans(charge, scale, upright),
      svg("path", { class: "measured", d: measured(charge, scale, time_s) }),
      ...charge.plans.flatMap((plan) => lines(plan, scale, "")),
      ...lines(expected(charge, time_s), scale, "ahead"),
    ];
    if (charge.reserve !== null) parts.push(level(charge.reserve, "reserve"));
    this.strip.replaceChildren(svg("title", {}, said(charge)), ...parts, this.now);
  }
}

// The charge now, in words.
function said({ measured, plans, ahead }) {
  const percent = measured.at(-1)?.percent;
  const words = [percent == null ? "unknown" : `${percent} %`];
  const here = plans.at(-1)?.at(-1);
  if (here) words.push(`${here.required.toFixed(0)} % required at the last position`);
  if (ahead.length) {
    const { action, percent: least, required_percent: required } = ahead[0];
    words.push(`after ${action} at least ${least.toFixed(0)} % planned, ${required.toFixed(0)} % required`);
  }
  return words.join("; ");
}

// The present plan from its last position on, at the times that it expects, none of which is past.
function expected({ plans, ahead, pinned_s }, time_s) {
  if (!ahead.length) return [];
  let t_s = pinned_s;
  const rest = ahead.map(({ duration_s, percent, required_percent: required }, i) => {
    t_s = i ? t_s + duration_s : Math.max(t_s + duration_s, time_s);
    return { t_s, percent, required };
  });
  return [plans.at(-1).at(-1), ...rest];
}

function scaleOf(history, state, width) {
  const { charge, time_s } = state;
  const horizon_s = history.mission.is_live ? expected(charge, time_s).at(-1)?.t_s ?? 0 : 0;
  const start_s = history.start_s, end_s = Math.max(history.end_s, horizon_s, start_s + 1);
  const top = MARGIN.top, bottom = HEIGHT_PX - MARGIN.bottom;
  const inner = Math.max(1, width - MARGIN.left - MARGIN.right);
  const highest = charge.measured.reduce((most, at) => Math.max(most, at.percent ?? 0), 0);
  const most = Math.min(100, 10 * Math.ceil((highest + 5) / 10));
  const step_s = STEPS_S.find((s) => (s / (end_s - start_s)) * inner >= TIMES_PX) ?? STEPS_S.at(-1);
  const first = Math.ceil(start_s / step_s);
  return {
    start_s, end_s, top, bottom, width,
    x: (t_s) => MARGIN.left + (Math.min(Math.max((t_s - start_s) / (end_s - start_s), 0), 1)) * inner,
    y: (percent) => bottom - (Math.min(percent, most) / most) * (bottom - top),
    time: (px) => start_s + ((px - MARGIN.left) / inner) * (end_s - start_s),
    times: Array.from({ length: Math.max(0, Math.floor(end_s / step_s) - first + 1) }, (_, i) => (first + i) * step_s)
      .filter((t_s) => ((t_s - start_s) / (end_s - start_s)) * inner < inner - 12),
    percents: [0, 50, 100].map((share) => Math.round((share / 100) * most)),
  };
}

// A gauge says what it said last until it says something else.
function measured({ measured: readings }, { x, y }, time_s) {
  const parts = [];
  readings.forEach(({ t_s, percent }, i) => {
    if (percent === null) return;
    const isJoined = i && readings[i - 1].percent !== null;
    parts.push(`${isJoined ? "L" : "M"}${x(t_s)} ${y(percent)}H${x(readings[i + 1]?.t_s ?? time_s)}`);
  });
  return parts.join("");
}

function lines(plan, { x, y, end_s }, name) {
  const seen = plan.filter((at, i) => at.t_s <= end_s || plan[i - 1]?.t_s < end_s);
  if (!seen.length) return [];
  const line = (key) => svg("polyline", {
    class: `${key === "percent" ? "planned" : "required"} ${name}`,
    points: seen.map((at) => `${x(at.t_s)},${y(at[key])}`).join(" ") });
  const dots = seen.slice(name ? 1 : 0).map((at) => svg("circle", { class: `position ${name}`, cx: x(at.t_s), cy: y(at.required), r: 2 }));
  return [line("required"), line("percent"), ...dots];
}

function replans({ replans: made }, { x, top }, upright) {
  let free = -Infinity;
  return made.flatMap(({ t_s, label }) => {
    const parts = [upright(t_s, "replan")];
    if (x(t_s) >= free) {
      free = x(t_s) + LEAST_LABEL_PX;
      parts.push(svg("text", { class: "number", x: x(t_s), y: top - 4 }, label));
    }
    return parts;
  });
}
