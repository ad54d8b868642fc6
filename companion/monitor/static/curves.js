// Altitude, speed, battery and clearance over time, a small strip each. A line stands where the
// slider is; to press and draw over a strip moves the slider. All of a run is drawn, also what is
// later than the slider, which is fainter.

import { byId, html, say, svg } from "./dom.js";

const HEIGHT_PX = 54;
const MARGIN = { left: 30, right: 4, top: 5, bottom: 4 };
const REDRAW_MS = 400; // of a live flight
const CURVES = [
  { name: "altitude", unit: "m", value: ({ enu }) => enu[2] },
  { name: "speed", unit: "m/s", value: ({ speed_mps }) => speed_mps },
  { name: "battery", unit: "%", value: ({ battery_percent }) => battery_percent },
  { name: "clearance", unit: "m", value: ({ clearance_m }) => clearance_m, absent: "no obstacle" },
];

export class CurvesView {
  constructor(seek) {
    this.seek = seek;
    this.strips = CURVES.map((curve) => new Strip(curve, (px) => this.look(px)));
    byId("curves").replaceChildren(...this.strips.map(({ element }) => element));
    this.drawn_ms = 0;
  }

  // Moves the slider to the time of a place on a strip.
  look(px) {
    if (!this.scale) return;
    const { start_s, end_s, inner } = this.scale;
    this.seek(start_s + ((px - MARGIN.left) / inner) * (end_s - start_s));
  }

  show(history, state, vehicle) {
    const { snapshots } = history, width = this.strips[0].svg.clientWidth;
    const version = [width, snapshots.length, history.end_s, state.touched.replan].join();
    const isDue = performance.now() - this.drawn_ms > REDRAW_MS || this.scale?.width !== width;
    if (version !== this.version && isDue && width > MARGIN.left + MARGIN.right) {
      [this.version, this.drawn_ms] = [version, performance.now()];
      this.scale = scaleOf(history, width);
      const replans_s = history.events.filter(({ kind }) => kind === "replan").map(({ t_s }) => t_s);
      for (const strip of this.strips) strip.draw(snapshots, replans_s, this.scale);
    }
    for (const strip of this.strips) strip.show(vehicle, this.scale?.x(state.time_s));
  }
}

function scaleOf(history, width) {
  const { start_s, end_s } = history, inner = width - MARGIN.left - MARGIN.right;
  const share = (t_s) => Math.min(Math.max((t_s - start_s) / Math.max(end_s - start_s, 1e-3), 0), 1);
  return { start_s, end_s, width, inner, x: (t_s) => MARGIN.left + share(t_s) * inner };
}

class Strip {
  constructor(curve, look) {
    this.curve = curve;
    this.now = html("strong");
    this.svg = svg("svg", { class: "strip", role: "img" });
    this.title = svg("title");
    this.later = svg("rect", { class: "later", y: 0, height: HEIGHT_PX });
    this.at = svg("line", { class: "now", y1: 0, y2: HEIGHT_PX });
    this.svg.append(this.title);
    this.element = html("figure", {}, html("figcaption", {}, `${curve.name} `, this.now), this.svg);
    this.svg.onpointerdown = (event) => {
      this.svg.setPointerCapture(event.pointerId);
      look(event.offsetX);
    };
    this.svg.onpointermove = (event) => {
      if (this.svg.hasPointerCapture(event.pointerId)) look(event.offsetX);
    };
  }

  draw(snapshots, replans_s, { width, x }) {
    const { name, unit, value } = this.curve;
    const known = snapshots.map((each) => value(each)).filter((number) => number != null);
    const least = Math.min(0, known.reduce((a, b) => Math.min(a, b), 0));
    const most = unit === "%" ? 100 : rounded(known.reduce((a, b) => Math.max(a, b), 0));
    const bottom = HEIGHT_PX - MARGIN.bottom;
    const y = (number) => bottom - ((number - least) / (most - least)) * (bottom - MARGIN.top);
    const level = (number) => [
      svg("line", { class: "grid", x1: MARGIN.left, x2: width - MARGIN.right, y1: y(number), y2: y(number) }),
      svg("text", { x: MARGIN.left - 4, y: y(number) + (number === most ? 6 : 2) }, String(number))];
    this.svg.setAttribute("viewBox", `0 0 ${width} ${HEIGHT_PX}`);
    this.title.textContent = `${name}, ${least.toFixed(0)} to ${most} ${unit}`;
    this.later.setAttribute("width", width);
    this.svg.replaceChildren(this.title, ...level(0), ...level(most),
      ...replans_s.map((t_s) => svg("line", { class: "replan", x1: x(t_s), x2: x(t_s), y1: MARGIN.top, y2: bottom })),
      svg("path", { class: "measured", d: path(snapshots, value, x, y) }), this.later, this.at);
  }

  show(vehicle, x) {
    const { unit, value, absent = "unknown" } = this.curve, number = vehicle && value(vehicle);
    say(this.now, number == null ? absent : `${number.toFixed(unit === "%" ? 0 : 1)} ${unit}`);
    if (x === undefined) return;
    this.later.setAttribute("x", x);
    for (const end of ["x1", "x2"]) this.at.setAttribute(end, x);
  }
}

// A whole number of what people count in, not below a value.
function rounded(number) {
  const power = 10 ** Math.floor(Math.log10(Math.max(number, 1)));
  return [1, 2, 3, 5, 10].map((times) => times * power).find((most) => most >= number) ?? 1;
}

// A pixel wide at least from point to point, with the least and the highest value in between.
function path(snapshots, value, x, y) {
  const parts = [];
  let pixel = null, isJoined = false;
  const flush = () => {
    if (!pixel) return;
    parts.push(`${isJoined ? "L" : "M"}${pixel.x.toFixed(1)} ${y(pixel.first).toFixed(1)}`);
    if (pixel.least !== pixel.most) parts.push(`V${y(pixel.least).toFixed(1)}V${y(pixel.most).toFixed(1)}V${y(pixel.last).toFixed(1)}`);
    [isJoined, pixel] = [true, null];
  };
  for (const each of snapshots) {
    const number = value(each), at = x(each.t_s);
    if (number == null) {
      flush();
      isJoined = false;
    } else if (pixel && at - pixel.x < 1) {
      pixel.least = Math.min(pixel.least, number);
      pixel.most = Math.max(pixel.most, number);
      pixel.last = number;
    } else {
      flush();
      pixel = { x: at, first: number, least: number, most: number, last: number };
    }
  }
  flush();
  return parts.join("");
}
