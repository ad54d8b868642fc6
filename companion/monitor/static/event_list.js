// What happened when, a line each: all of it, or the kinds and words that a reader chooses. A line
// leads to its time.

import { byId, html, minutes } from "./dom.js";

const KINDS = {
  plans: new Set(["plan", "replan", "awaited", "dropped", "taken up", "lap", "engine failed"]),
  skills: new Set(["at", "done", "failed", "lap", "symbol", "photo", "marker", "progress", "report"]),
  faults: new Set([
    "failed", "withdrawn", "violation", "violated before", "crash", "dropped", "lost", "gate", "silent",
    "unknown", "map", "port lost", "engine failed",
  ]),
};

export class EventList {
  constructor(history, seek) {
    this.seek = seek;
    this.forPrograms = new Set(history.mission.for_programs);
    this.lines = [];
    this.list = byId("lines");
    this.list.replaceChildren();
    byId("kinds").onchange = byId("words").oninput = () => this.filter();
  }

  add(event) {
    if (this.forPrograms.has(event.kind)) return;
    const element = html("li", { "data-kind": event.kind },
      html("button", { type: "button", onclick: () => this.seek(event.t_s) },
        html("time", {}, minutes(event.t_s)), html("span", {}, event.text)));
    element.hidden = !isChosen(event);
    this.lines.push({ element, event });
    this.list.append(element);
  }

  filter() {
    for (const { element, event } of this.lines) element.hidden = !isChosen(event);
    this.shown = null;
  }

  // The newest of the lines that are listed is the present one.
  show(time_s) {
    const past = this.lines.filter(({ event }) => event.t_s <= time_s).length;
    if (this.shown === past) return;
    this.shown = past;
    const present = this.lines.slice(0, past).findLast(({ element }) => !element.hidden)?.element;
    this.lines.forEach(({ element }, i) => {
      element.toggleAttribute("data-future", i >= past);
      element.toggleAttribute("data-present", element === present);
    });
    const { list } = this;
    if (present) list.scrollTop = present.offsetTop - list.clientHeight + present.clientHeight;
  }
}

function isChosen({ kind, text }) {
  const kinds = KINDS[byId("kinds").value];
  return (!kinds || kinds.has(kind)) && text.toLowerCase().includes(byId("words").value.toLowerCase());
}
