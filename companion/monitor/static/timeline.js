// Time: where in the run the page is, and what happened when. Marks and lines lead to their time.

import { byId, html, minutes, say } from "./dom.js";
import { EventList } from "./event_list.js";

const MOST_BEHIND_S = 10;
const SPEEDS = [0.5, 1, 2, 5, 20];

// A little behind what comes in steps, so that the vehicle moves without them.
function approached(time_s, end_s, dt_s) {
  const gap_s = end_s - time_s;
  return gap_s < 0.02 || gap_s > MOST_BEHIND_S ? end_s : time_s + gap_s * Math.min(1, 5 * dt_s);
}

export class Timeline {
  // `isFollowing`: the page looks at the newest time, as it comes.
  constructor(history) {
    this.history = history;
    this.isFollowing = history.mission.is_live;
    this.isPlaying = !this.isFollowing;
    this.time_s = 0;
    this.hasJumped = false;
    this.listed = 0;
    this.lines = new EventList(history, (time_s) => this.seek(time_s));
    this.marks = [];
    byId("marks").replaceChildren();
    byId("live").hidden = !history.mission.is_live;
  }

  connect() {
    byId("play").onclick = () => this.toggle();
    byId("live").onclick = () => { this.isFollowing = true; };
    byId("time").oninput = (input) => this.seek(Number(input.target.value));
    document.onkeydown = (event) => this.key(event);
  }

  get speed() {
    return Number(byId("pace").value);
  }

  seek(time_s) {
    this.time_s = Math.min(Math.max(time_s, this.history.start_s), this.history.end_s);
    this.isFollowing = false;
    this.hasJumped = true; // also by less than the clock shows
  }

  toggle() {
    if (this.isFollowing) this.seek(this.history.end_s);
    else if (!this.isPlaying && this.time_s >= this.history.end_s) this.seek(this.history.start_s);
    this.isPlaying = !this.isPlaying;
  }

  key(event) {
    if (event.ctrlKey || event.altKey || event.metaKey) return;
    if (event.target.tagName === "SELECT" || event.target.type === "search") return;
    const step_s = event.shiftKey ? 10 : 1;
    const isOnButton = ["BUTTON", "SUMMARY"].includes(event.target.tagName);
    const actions = {
      ArrowLeft: () => this.seek(this.time_s - step_s),
      ArrowRight: () => this.seek(this.time_s + step_s),
      Home: () => this.seek(0),
      End: () => this.seek(Infinity),
      " ": isOnButton ? null : () => this.toggle(),
      "+": () => this.faster(1),
      "-": () => this.faster(-1),
    };
    if (!actions[event.key]) return;
    event.preventDefault();
    actions[event.key]();
  }

  faster(by) {
    const next = SPEEDS[SPEEDS.indexOf(this.speed) + by];
    if (next) byId("pace").value = String(next);
  }

  // Passes wall time; what time of the run is it then?
  advance(dt_s) {
    const { start_s, end_s, mission } = this.history;
    if (this.isFollowing) this.time_s = approached(this.time_s, end_s, dt_s);
    else if (this.isPlaying) {
      this.time_s = Math.min(Math.max(this.time_s, start_s) + dt_s * this.speed, end_s);
      if (this.time_s >= end_s) {
        this.isPlaying = false;
        this.isFollowing = mission.is_live;
      }
    }
    return this.time_s;
  }

  show() {
    this.list();
    const { start_s, end_s } = this.history;
    const slider = byId("time");
    const clock = `${minutes(this.time_s)} / ${minutes(end_s)}`;
    if (this.hasJumped || clock !== byId("clock").textContent) {
      this.hasJumped = false;
      [slider.min, slider.max, slider.value] = [start_s, end_s, this.time_s];
      slider.setAttribute("aria-valuetext", minutes(this.time_s));
    }
    say(byId("clock"), clock);
    say(byId("play"), this.isPlaying || this.isFollowing ? "Pause" : "Play");
    byId("live").toggleAttribute("data-on", this.isFollowing);
    for (const { element, t_s } of this.marks) {
      element.style.setProperty("--at", (t_s - start_s) / Math.max(end_s - start_s, 1e-3));
    }
    this.lines.show(this.time_s);
  }

  // Lines and marks for the events that have come.
  list() {
    const { events } = this.history;
    for (; this.listed < events.length; this.listed += 1) {
      const event = events[this.listed];
      this.lines.add(event);
      if (event.kind !== "replan" && event.kind !== "violation") continue;
      const label = event.kind === "violation" ? "!" : event.plan ? String(event.number) : "×";
      const mark = html("button", {
        type: "button", class: "mark", title: event.text, "aria-label": event.text,
        onclick: () => this.seek(event.t_s) }, label);
      this.marks.push({ element: mark, t_s: event.t_s });
      byId("marks").append(mark);
    }
  }
}
