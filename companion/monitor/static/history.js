// All that is known of a run, and what it amounts to at any time of it. A live page looks at the
// newest time, a replay at any: the same events, folded up to there.

import { applyCharge, freshCharge } from "./charge.js";

export class History {
  constructor(mission) {
    this.mission = mission;
    this.events = [];
    this.snapshots = [];
    this.state = fresh();
  }

  get end_s() {
    const newest = (list) => (list.length ? list[list.length - 1].t_s : 0);
    return Math.max(newest(this.events), newest(this.snapshots));
  }

  get start_s() {
    return Math.min(this.events[0]?.t_s ?? Infinity, this.snapshots[0]?.t_s ?? Infinity, this.end_s);
  }

  // What the events up to a time amount to.
  at(time_s) {
    if (time_s < this.state.time_s) this.state = fresh();
    this.state.time_s = time_s;
    while (this.state.count < this.events.length && this.events[this.state.count].t_s <= time_s) {
      apply(this.state, this.events[this.state.count]);
      this.state.count += 1;
    }
    return this.state;
  }

  // The number of snapshots up to a time.
  flown(time_s) {
    let low = 0, high = this.snapshots.length;
    while (low < high) {
      const middle = (low + high) >> 1;
      if (this.snapshots[middle].t_s <= time_s) low = middle + 1;
      else high = middle;
    }
    return low;
  }

  // The vehicle at a time, between two snapshots on the line through them.
  vehicle(time_s) {
    const count = this.flown(time_s);
    if (!count) return null;
    const [before, after] = [this.snapshots[count - 1], this.snapshots[count]];
    if (!after || after.t_s - before.t_s > 3 * this.mission.period_s) return before;
    const share = (time_s - before.t_s) / (after.t_s - before.t_s);
    const turn = ((after.yaw_deg - before.yaw_deg + 540) % 360) - 180;
    return {
      ...before,
      enu: before.enu.map((x, i) => x + share * (after.enu[i] - x)),
      yaw_deg: before.yaw_deg + share * turn,
    };
  }
}

// `touched` has for each kind the number of the last event of it, so that a panel knows what is new.
function fresh() {
  return {
    time_s: -Infinity, count: 0, touched: {}, nodes: [], statuses: [], said: [], legs: [],
    automata: [], states: [], taken: [], due: [], dropped: new Set(), withdrawn: new Set(), facts: new Map(), cells: new Map(),
    plan: null, phase: "", ending: null, planned_s: 0, charge: freshCharge(), kept: { within: [], keep_out: [] },
  };
}

function apply(state, event) {
  state.touched[event.kind] = state.count + 1;
  applyCharge(state.charge, event);
  switch (event.kind) {
    case "plan":
    case "replan":
      state.plan = event;
      break;
    case "tree":
      state.nodes = event.nodes;
      state.statuses = event.nodes.map(() => "INVALID");
      state.said = event.nodes.map(() => "");
      state.planned_s = event.t_s;
      break;
    case "status":
      for (const [number, status, said] of event.changed) {
        state.statuses[number] = status;
        state.said[number] = said;
      }
      break;
    case "path":
      state.legs = event.legs;
      break;
    case "automata":
      state.automata = event.automata;
      break;
    case "states":
      [state.states, state.taken, state.due] = [event.states, event.taken, event.due];
      break;
    case "dropped":
      state.dropped.add(event.line);
      break;
    case "taken up":
      state.dropped.delete(event.line);
      break;
    case "withdrawn":
      state.withdrawn.add(event.belief);
      break;
    case "restored":
      state.withdrawn.delete(event.belief);
      break;
    case "event":
      state.facts.set(event.event, event.holds);
      break;
    case "cells":
      for (const [row, col, occupied] of event.cells) state.cells.set(`${row},${col}`, occupied);
      break;
    case "fence":
      if (event.type === "FenceKept") state.kept = event;
      break;
    case "phase":
      state.phase = event.text;
      break;
    case "end":
      state.ending = event;
      break;
  }
}
