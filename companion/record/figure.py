"""flight.png: the flight over the shaded distance field, as in Fig. 7 of the paper.

One panel per plan: the track flown with it is bold, with arrows, and the track before is pale. A
darker cell is nearer to an obstacle. If plans consider the charge, or the vehicle was charged, the
charge over time is drawn below.
"""

from __future__ import annotations

import math
import textwrap
from pathlib import Path

import matplotlib as mpl
import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine
from matplotlib.lines import Line2D

from companion.geometry import Ned, enu_from_ned
from companion.record.backdrop import Backdrop
from companion.record.charge_figure import draw_charge
from companion.record.labels import write_names
from companion.record.trail import Trail

PANEL_INCHES = (5.4, 4.2)
CHARGE_INCHES = 2.1
"""Height of the strip with the charge."""
LEGEND_INCHES = 0.35
LEGEND_COLUMNS = 3
"""Most columns of a legend, for each panel above it: more would be wider than the figure."""
COLUMNS = 3
"""Most panels side by side."""
SETTLING_LAYOUTS = 2
"""Layouts before the final one: with three there is room for titles above equal scales."""
TITLE_LETTERS = 50
"""Most letters in a line of a title."""
ARROWS, ARROW_EVERY = 6, 0.2
"""Most arrows of a part; their distance, as a share of the panel's width."""
ARROW = {"arrowstyle": "-|>", "color": "tab:blue", "mutation_scale": 14, "shrinkA": 0, "shrinkB": 0}
NOW, BEFORE, BEGIN, END = "tab:blue", "lightsteelblue", "tab:green", "tab:red"


def draw_flight(backdrop: Backdrop, trail: Trail, path: Path) -> None:
    """Draws a flight to a file: PNG, PDF or SVG, by its name.

    Equal flights give equal files; an SVG keeps text as text.
    """
    undated = {".pdf": {"CreationDate": None}, ".svg": {"Date": None}}
    with mpl.rc_context({"svg.hashsalt": "flight", "svg.fonttype": "none"}):
        metadata = undated.get(path.suffix.lower())
        figure_of(backdrop, trail).savefig(path, dpi=110, metadata=metadata)


def figure_of(backdrop: Backdrop, trail: Trail) -> Figure:
    """A flight, with a panel for each part of its trail; east to the right, north up, metres.

    Below is the charge, if it is of interest.
    """
    panels = max(1, len(trail.parts))
    rows = math.ceil(panels / COLUMNS)
    columns = math.ceil(panels / rows)
    width, height = PANEL_INCHES[0] * columns, PANEL_INCHES[1] * rows
    strip = CHARGE_INCHES if trail.charge.says_something else 0.0
    layout = ConstrainedLayoutEngine()
    figure = Figure(figsize=(width, height + strip + LEGEND_INCHES), layout=layout)
    FigureCanvasAgg(figure)
    heights = [PANEL_INCHES[1]] * rows + [strip] * bool(strip)
    grid = figure.add_gridspec(len(heights), columns, height_ratios=heights)
    if strip:
        draw_charge(figure.add_subplot(grid[rows, :]), trail.charge, LEGEND_COLUMNS * columns)
    parts = [(title, _east_north(positions)) for title, positions in trail.parts]
    axes = [figure.add_subplot(grid[divmod(i, columns)]) for i in range(panels)]
    for i, axis in enumerate(axes):
        backdrop.draw(axis)
        for _, points in parts[:i]:
            axis.plot(*points.T, color=BEFORE, linewidth=1.2)
        if parts:
            title, points = parts[i]
            _draw_part(axis, points)
            axis.set_title(textwrap.fill(f"({chr(ord('a') + i)}) {title}", TITLE_LETTERS))
    handles = [*_legend(len(parts)), *backdrop.legend]
    figure.legend(
        handles=handles,
        loc="outside lower center",
        ncols=min(len(handles), LEGEND_COLUMNS * columns),
        fontsize="small",
        frameon=False,
    )
    for _ in range(SETTLING_LAYOUTS):
        layout.execute(figure)
    names = {name: enu_from_ned(at)[:2] for name, (at, _) in backdrop.places.items()}
    for axis in axes:
        write_names(axis, names)
    return figure


def _east_north(positions: list[Ned]) -> npt.NDArray[np.float64]:
    """(n, 2) east and north of positions."""
    return np.array([enu_from_ned(p)[:2] for p in positions]).reshape(-1, 2)


def _draw_part(axis: Axes, points: npt.NDArray[np.float64]) -> None:
    """Draws the track of one plan."""
    if not len(points):
        return
    axis.plot(*points.T, color=NOW, linewidth=2.0)
    axis.plot(*points[0], "^", color=BEGIN, markersize=7)
    axis.plot(*points[-1], "s", color=END, markersize=6)
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    low, high = axis.get_xlim()
    count = min(ARROWS, int(along[-1] / (ARROW_EVERY * (high - low))))
    for share in (np.arange(count) + 0.5) / max(1, count):
        here = min(int(np.searchsorted(along, share * along[-1])), len(points) - 1)
        before = int(np.searchsorted(along, along[here] - 0.02 * (high - low)))
        if before < here:
            axis.annotate(
                "",
                points[here],
                xytext=points[before],
                arrowprops=ARROW,
            )


def _legend(parts: int) -> list[Line2D]:
    if not parts:
        return []
    flown = Line2D([], [], color=NOW, linewidth=2.0, label="flown with this plan")
    before = Line2D([], [], color=BEFORE, linewidth=1.2, label="before")
    begin = Line2D([], [], color=BEGIN, marker="^", linestyle="", label="where it begins")
    end = Line2D([], [], color=END, marker="s", linestyle="", label="where it ends")
    return [flown, *[before] * (parts > 1), begin, end]
