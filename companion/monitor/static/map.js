// The map: distance field, places, plan, trail, vehicle. East to the right, north up; the drawing's
// unit is the metre, and --px is the length of a pixel in it.

import { byId, say, svg } from "./dom.js";

const SCALES_M = [500, 200, 100, 50, 20, 10, 5, 2, 1, 0.5, 0.2, 0.1];
const LONGEST_SCALE_PX = 120, LONGEST_SCALE = 1 / 5; // of the map's width
const SCALE_LABEL_PX = 125, SCALE_HEIGHT_PX = 34;
const SVG_Y = (north) => -north;
const line = (points) => points.map(([east, north]) => `${east},${SVG_Y(north)}`).join(" ");

export class MapView {
  constructor(mission, view) {
    this.map = mission.map;
    this.view = view;
    this.hall = byId("hall");
    this.overlay = byId("overlay");
    this.shade = Uint8Array.from(atob(this.map.shade), (c) => c.charCodeAt(0));
    const { rows, cols, cell_m, east_m, north_m } = this.map;
    this.width_m = cols * cell_m;
    this.height_m = rows * cell_m;
    this.hall.style.setProperty("--ratio", cols / rows);
    this.corner = [east_m, SVG_Y(north_m + this.height_m)];
    this.layers = Object.fromEntries(
      ["fence", "kept", "low_walls", "keep_out", "places", "cells", "path", "past", "trail", "areas", "names", "carrot", "setpoint", "vehicle"]
        .map((name) => [name, svg("g", { class: name })]));
    this.overlay.replaceChildren(svg("title"), ...Object.values(this.layers));
    this.layers.fence.append(svg("polygon", { points: line(mission.fence) }));
    this.layers.low_walls.append(
      ...mission.low_walls.map((wall) => svg("polygon", { points: line(wall) })));
    this.layers.keep_out.append(
      ...mission.keep_out.map(({ corners }) => svg("polygon", { points: line(corners) })));
    this.fence = fenceName(mission.fence);
    this.layers.areas.append(this.fence, ...mission.keep_out.map(zoneName));
    this.layers.places.append(...mission.places.map(region));
    this.names = mission.places.map(name);
    this.sites = mission.places;
    this.layers.names.append(...this.names);
    this.past = this.layers.past.appendChild(svg("polyline"));
    this.trail = this.layers.trail.appendChild(svg("polyline"));
    this.carrot = this.layers.carrot.appendChild(svg("line"));
    this.setpoint = this.layers.setpoint.appendChild(svg("path", { d: "M0-7 7 0 0 7-7 0Z" }));
    this.vehicle = this.layers.vehicle.appendChild(svg("path", { d: "M0-13 9 11 0 6-9 11Z" }));
    this.fit();
    this.paint();
  }

  // Shows the part of the map that a view says, in the window as it is.
  look(view) {
    this.view = view;
    this.fit();
  }

  fit() {
    if (!this.hall.clientWidth) return; // not laid out yet; the observer of its size comes again
    const { left, top, width } = this.view;
    this.px = (this.width_m * width) / this.hall.clientWidth;
    this.overlay.style.setProperty("--px", this.px);
    this.overlay.setAttribute("viewBox", [
      this.corner[0] + left * this.width_m, this.corner[1] + top * this.height_m,
      width * this.width_m, width * this.height_m].join(" "));
    byId("raster").style.transform =
      `scale(${1 / width}) translate(${-100 * left}%, ${-100 * top}%)`;
    const longest_px = Math.min(LONGEST_SCALE_PX, LONGEST_SCALE * this.hall.clientWidth);
    const length_m = SCALES_M.find((m) => m / this.px <= longest_px) ?? SCALES_M.at(-1);
    byId("scale").style.setProperty("--length", `${length_m / this.px}px`);
    say(byId("scale"), `${length_m} m, north is up`);
    const covered = length_m / this.px + SCALE_LABEL_PX;
    byId("scale").toggleAttribute("data-right",
      this.hasSite(0, covered) && !this.hasSite(this.hall.clientWidth - covered, Infinity));
    for (const text of this.names) text.setAttribute("dy", -5 * this.px);
    for (const [name, px] of [["dx", 5], ["dy", 15]]) this.fence.setAttribute(name, px * this.px);
  }

  // Whether a place is where the scale would lie, from one pixel to another along the lower edge.
  hasSite(from, to) {
    const { left, top, width } = this.view, lowest = this.hall.clientHeight - SCALE_HEIGHT_PX;
    return this.sites.some(({ enu, radius_m }) => {
      const [x, y] = this.share(enu), reach = (radius_m ?? 0) / this.px;
      const across = ((x - left) / width) * this.hall.clientWidth;
      return ((y - top) / width) * this.hall.clientHeight + reach > lowest && across + reach > from && across - reach < to;
    });
  }

  // Where a point is, in shares of the map from its north-western corner.
  share([east, north]) {
    return [(east - this.corner[0]) / this.width_m, (SVG_Y(north) - this.corner[1]) / this.height_m];
  }

  // The distance field, in the colours of the light or the dark page.
  paint() {
    const style = getComputedStyle(this.hall);
    const colour = (name) => style.getPropertyValue(name).trim().split(" ").map(Number);
    const [wall, near, far] = [colour("--wall"), colour("--near"), colour("--far")];
    const canvas = byId("raster");
    [canvas.width, canvas.height] = [this.map.cols, this.map.rows];
    const context = canvas.getContext("2d");
    const image = context.createImageData(canvas.width, canvas.height);
    this.shade.forEach((value, i) => {
      const share = (value - 1) / 254;
      for (let c = 0; c < 3; c += 1) {
        image.data[4 * i + c] = value ? near[c] + share * (far[c] - near[c]) : wall[c];
      }
      image.data[4 * i + 3] = 255;
    });
    context.putImageData(image, 0, 0);
  }

  show(history, state, vehicle) {
    if (this.drawnCells !== state.touched.cells) this.drawCells(state);
    if (this.drawnFence !== state.touched.fence) {
      this.drawnFence = state.touched.fence;
      this.drawKept(state.kept);
    }
    if (this.drawnPath !== state.touched.path) {
      this.drawnPath = state.touched.path;
      this.layers.path.replaceChildren(
        ...state.legs.map((leg) => svg("polyline", { points: line(leg) })));
    }
    this.drawTrail(history, state);
    this.layers.vehicle.toggleAttribute("hidden", !vehicle);
    const setpoint = vehicle?.setpoint;
    this.layers.setpoint.toggleAttribute("hidden", !setpoint);
    this.layers.carrot.toggleAttribute("hidden", !setpoint);
    if (!vehicle) return;
    this.overlay.firstChild.textContent =
      `Vehicle ${vehicle.enu[0].toFixed(1)} m east, ${vehicle.enu[1].toFixed(1)} m north`;
    this.place(this.vehicle, vehicle.enu, vehicle.yaw_deg);
    if (!setpoint) return;
    this.place(this.setpoint, setpoint, 0);
    const ends = { x1: vehicle.enu[0], y1: SVG_Y(vehicle.enu[1]), x2: setpoint[0], y2: SVG_Y(setpoint[1]) };
    for (const [name, value] of Object.entries(ends)) this.carrot.setAttribute(name, value);
  }

  // The fence of somebody else that the autopilot keeps.
  drawKept({ within, keep_out }) {
    const drawn = (areas, kind) => areas.map((corners) =>
      svg("polygon", { class: kind, points: line(corners.map(([north, east]) => [east, north])) }));
    this.layers.kept.replaceChildren(...drawn(within, "fence"), ...drawn(keep_out, "keep_out"));
    byId("kept").hidden = !within.length && !keep_out.length;
  }

  // What was flown under the present plan, and before; up to the last snapshot.
  drawTrail(history, state) {
    const count = history.flown(state.time_s), cut = Math.min(count, history.flown(state.planned_s));
    if (this.drawnTrail === `${count} ${cut}`) return;
    this.drawnTrail = `${count} ${cut}`;
    const points = (from, to) => line(history.snapshots.slice(from, to).map((s) => s.enu));
    this.past.setAttribute("points", points(0, cut));
    this.trail.setAttribute("points", points(Math.max(cut - 1, 0), count));
  }

  place(shape, [east, north], yaw_deg) {
    shape.setAttribute(
      "transform", `translate(${east} ${SVG_Y(north)}) rotate(${yaw_deg}) scale(${this.px})`);
  }

  drawCells(state) {
    this.drawnCells = state.touched.cells;
    const { cell_m, east_m, north_m } = this.map;
    this.layers.cells.replaceChildren(...[...state.cells].map(([key, occupied]) => {
      const [row, col] = key.split(",").map(Number);
      return svg("rect", {
        x: east_m + col * cell_m, y: SVG_Y(north_m + (row + 1) * cell_m),
        width: cell_m, height: cell_m, class: occupied ? "seen" : "gone",
      });
    }));
  }
}

const region = ({ enu: [east, north], radius_m, corners }) => corners
  ? svg("polygon", { points: line(corners) })
  : svg("circle", { cx: east, cy: SVG_Y(north), r: radius_m });

const name = ({ name, enu: [east, north], radius_m, corners }) => {
  const top = corners ? Math.max(...corners.map((corner) => corner[1])) : north + radius_m;
  return svg("text", { x: east, y: SVG_Y(top) }, name);
};

// The fence has its name in its north-western corner, a zone in its middle.
const fenceName = (corners) => {
  const [east, north] = corners.reduce((a, b) => (b[1] - b[0] > a[1] - a[0] ? b : a));
  return svg("text", { class: "area fence-name", x: east, y: SVG_Y(north) }, "fence");
};

const zoneName = ({ name, corners }) => {
  const middle = (axis) => corners.reduce((sum, corner) => sum + corner[axis], 0) / corners.length;
  return svg("text", { class: "area", x: middle(0), y: SVG_Y(middle(1)) }, name);
};
