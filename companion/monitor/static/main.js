// Joins the stream to what is shown. Everything drawn is a function of the history and the time.

import { TaskView } from "./automata.js";
import { ChargeView } from "./charge.js";
import { CurvesView } from "./curves.js";
import { byId, say } from "./dom.js";
import { explain } from "./explained.js";
import { FollowingZoom } from "./following.js";
import { History } from "./history.js";
import { MapView } from "./map.js";
import { PlanView, showVehicle } from "./panels.js";
import { Timeline } from "./timeline.js";
import { TreeView } from "./tree.js";

let page = null;
let isConnected = false;

const zoom = new FollowingZoom(byId("hall"), byId("whole"), byId("follow"), () => page?.map.look(zoom.view));

const stream = new EventSource("stream");
const on = (kind, take) => stream.addEventListener(kind, (message) => take(JSON.parse(message.data)));
on("mission", open);
on("events", (events) => page.history.events.push(...events));
on("snapshots", (snapshots) => page.history.snapshots.push(...snapshots));
stream.onopen = () => { isConnected = true; };
stream.onerror = () => {
  isConnected = false;
  if (page?.history.events.at(-1)?.kind === "end") stream.close(); // nothing more will come
};

function open(mission) {
  const history = new History(mission);
  const timeline = new Timeline(history);
  timeline.connect();
  page = {
    history, timeline, map: new MapView(mission, zoom.view), tree: new TreeView(), plan: new PlanView(),
    task: new TaskView(), charge: new ChargeView((time_s) => timeline.seek(time_s)),
    curves: new CurvesView((time_s) => timeline.seek(time_s)),
  };
  byId("name").textContent = mission.name;
  document.title = `${mission.name}, companion monitor`;
}

function badge(state) {
  if (state.ending) return state.ending.exit_code ? ["bad", "ended"] : ["good", "ended"];
  if (!page.history.mission.is_live) return ["", "replay"];
  if (!isConnected) return ["bad", "no connection"];
  return page.timeline.isFollowing ? ["live", "live"] : ["", "looking back"];
}

const PERIOD_MS = 50; // often enough for the eye, and kind to the battery of a phone
let before_ms = performance.now();
function frame(now_ms) {
  requestAnimationFrame(frame);
  const dt_s = (now_ms - before_ms) / 1000;
  if (dt_s * 1000 < PERIOD_MS - 5) return;
  before_ms = now_ms;
  if (page) {
    const time_s = page.timeline.advance(dt_s);
    const state = page.history.at(time_s);
    const vehicle = page.history.vehicle(time_s);
    if (zoom.isFollowing && vehicle) zoom.centre(page.map.share(vehicle.enu));
    page.map.show(page.history, state, vehicle);
    page.tree.show(state);
    page.plan.show(state);
    page.task.show(state);
    page.charge.show(page.history, state);
    page.curves.show(page.history, state, vehicle);
    page.timeline.show();
    showVehicle(vehicle, state);
    const [kind, text] = badge(state);
    say(byId("badge"), text);
    byId("badge").dataset.kind = kind;
  }
}
requestAnimationFrame(frame);
explain();

new ResizeObserver(() => page?.map.fit()).observe(byId("hall"));
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => page?.map.paint());
