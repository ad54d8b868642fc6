"""flight.png: the flight over the shaded distance field, as Fig. 7 of the paper.

One panel per plan: what was flown while it was valid is drawn bold, what came before pale. The
darker a cell, the nearer the next obstacle. Below, where plans reckon with the charge, or the
vehicle was charged, the charge over time.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.patches import Polygon

from companion.geometry import Ned, NorthEast, enu_from_ned
from companion.mission.model import Mission
from companion.record.charge_figure import draw_charge
from companion.record.trail import Trail

PANEL_INCHES = (5.4, 4.2)
CHARGE_INCHES = 2.1
"""Height of the strip of the charge."""
COLUMNS = 3
"""At most so many panels side by side."""
SHADE_LIMIT_M = 3.0
"""Distance to the next obstacle from which on a cell is white."""


def draw_flight(mission: Mission, trail: Trail, path: Path) -> None:
    """Draws a flight to a PNG file."""
    figure_of(mission, trail).savefig(path, dpi=110)


def figure_of(mission: Mission, trail: Trail) -> Figure:
    """A flight, a panel for each part of its trail; east to the right, north up, metres.

    Below is the charge, if it says something.
    """
    panels = max(1, len(trail.parts))
    rows = math.ceil(panels / COLUMNS)
    columns = math.ceil(panels / rows)
    width, height = PANEL_INCHES[0] * columns, PANEL_INCHES[1] * rows
    strip = CHARGE_INCHES if trail.charge.says_something else 0.0
    figure = Figure(figsize=(width, height + strip), layout="constrained")
    FigureCanvasAgg(figure)
    heights = [PANEL_INCHES[1]] * rows + [strip] * bool(strip)
    grid = figure.add_gridspec(len(heights), columns, height_ratios=heights)
    if strip:
        draw_charge(figure.add_subplot(grid[rows, :]), trail.charge)
    axes = [figure.add_subplot(grid[divmod(i, columns)]) for i in range(panels)]
    for i, axis in enumerate(axes):
        _draw_hall(mission, axis)
        for _, positions in trail.parts[:i]:
            _draw_path(axis, positions, is_present=False)
        if trail.parts:
            title, positions = trail.parts[i]
            _draw_path(axis, positions, is_present=True)
            axis.set_title(f"({chr(ord('a') + i)}) {title}")
    return figure


def _draw_hall(mission: Mission, axis: Axes) -> None:
    grid = mission.grid
    rows, cols = grid.occupied.shape
    north, east = grid.origin
    extent = (east, east + cols * grid.cell_m, north, north + rows * grid.cell_m)
    near = np.minimum(grid.distance_m / SHADE_LIMIT_M, 1.0)
    shade = np.where(grid.occupied, 0.0, 0.25 + 0.75 * near)
    axis.imshow(shade, cmap="gray", vmin=0.0, vmax=1.0, origin="lower", extent=extent)
    for wall in mission.walls:
        if wall.up_m is not None:
            axis.add_patch(_patch(wall.corners, edgecolor="tab:gray", hatch="xx"))
    for zone in mission.limits.keep_out.values():
        axis.add_patch(_patch(zone, edgecolor="tab:red", hatch="//"))
    for place in mission.places.values():
        x, y, _ = enu_from_ned(place.position)
        if corners := place.region.outline():
            axis.add_patch(_patch(corners, edgecolor="tab:orange"))
        axis.plot(x, y, "o", color="tab:orange", markersize=5)
        axis.annotate(place.name, (x, y), xytext=(4, 4), textcoords="offset points", color="k")
    axis.set_aspect("equal")
    axis.set_xlabel("east [m]")
    axis.set_ylabel("north [m]")


def _patch(corners: Iterable[NorthEast], edgecolor: str, hatch: str | None = None) -> Polygon:
    points = [(east, north) for north, east in corners]
    return Polygon(points, facecolor="none", edgecolor=edgecolor, hatch=hatch)


def _draw_path(axis: Axes, positions: list[Ned], is_present: bool) -> None:
    if not positions:
        return
    points = np.array([enu_from_ned(p) for p in positions])
    color, width = ("tab:blue", 2.0) if is_present else ("lightsteelblue", 1.2)
    axis.plot(points[:, 0], points[:, 1], color=color, linewidth=width)
    if is_present:
        axis.plot(*points[0, :2], "^", color="tab:green", markersize=7)
        axis.plot(*points[-1, :2], "s", color="tab:red", markersize=6)
