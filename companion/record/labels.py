"""Places names beside points where they cover each other and the drawing the least.

Each name has eight candidate positions around its point, and eight farther away. They are tried in
the usual order, right and above first, and the one that covers least is taken (Christensen, Marks
and Shieber, An empirical study of algorithms for point-feature label placement, ACM Transactions on
Graphics 14, 1995).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import chain

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.font_manager import FontProperties
from matplotlib.textpath import TextPath
from matplotlib.transforms import Bbox

GAPS = (4.0, 16.0)
"""Distances of a name from its point, in 1/72 inch, as all lengths here."""
AROUND = ((1, 1), (1, -1), (-1, 1), (-1, -1), (1, 0), (-1, 0), (0, 1), (0, -1))
SIZE, HEIGHT = 9.0, 12.0
STEP = 2.0
"""Distance of the sample points on lines that should not be covered."""
NAME, EDGE, POINT, FAR = 2000.0, 100.0, 1.0, 15.0
"""Costs: covering another name, leaving the panel, covering a sample point, being far away."""
PAPER = {"boxstyle": "square,pad=0.1", "facecolor": "white", "alpha": 0.8, "linewidth": 0}
"""Background of each name, so that it can be read over a line that it covers."""


def write_names(axis: Axes, names: Mapping[str, tuple[float, float]]) -> None:
    """Writes names into a panel that is laid out and otherwise drawn.

    Args:
        axis: the panel.
        names: each with its point, in data units.
    """
    per_point = axis.figure.dpi / 72.0
    to_points = axis.transData.transform
    panel = axis.get_window_extent()
    frame = Bbox(panel.get_points() / per_point)
    anchors = {name: to_points(point) / per_point for name, point in names.items()}
    covered = np.vstack([*_drawn(axis, per_point), *anchors.values()])
    taken: list[Bbox] = []
    for name, anchor in anchors.items():
        outline = TextPath((0, 0), name, prop=FontProperties(size=SIZE)).get_extents()
        size = outline.width + 2.0, HEIGHT
        boxes = [_box(anchor, size, gap, side) for gap in GAPS for side in AROUND]
        costs = [_cost(box, frame, taken, covered) for box in boxes]
        costs = [cost + FAR * (i >= len(AROUND)) for i, cost in enumerate(costs)]
        best = boxes[costs.index(min(costs))]
        taken.append(best)
        written = axis.annotate(
            name,
            names[name],
            xytext=(best.x0 + 1.0 - anchor[0], best.y0 - anchor[1]),
            textcoords="offset points",
            fontsize=SIZE,
            verticalalignment="bottom",
            bbox=PAPER,
        )
        written.set_in_layout(False)


def _drawn(axis: Axes, per_point: float) -> Iterator[npt.NDArray[np.float64]]:
    """(n, 2) points along each line and each outline of a panel, evenly spaced."""
    paths = [line.get_path().transformed(line.get_transform()) for line in axis.lines]
    paths += [patch.get_path().transformed(patch.get_transform()) for patch in axis.patches]
    for corners in chain.from_iterable(path.to_polygons(closed_only=False) for path in paths):
        points = np.asarray(corners) / per_point
        steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
        along = np.concatenate([[0.0], steps.cumsum()])
        chosen = np.arange(0.0, along[-1] + STEP, STEP)
        yield np.column_stack([np.interp(chosen, along, each) for each in points.T])


def _box(
    anchor: npt.NDArray[np.float64], size: tuple[float, float], gap: float, side: tuple[int, int]
) -> Bbox:
    """The box of a name on one side of its point."""
    (width, height), (right, up) = size, side
    x = anchor[0] + right * gap - {1: 0.0, 0: width / 2, -1: width}[right]
    y = anchor[1] + up * gap - {1: 0.0, 0: height / 2, -1: height}[up]
    return Bbox.from_bounds(x, y, width, height)


def _cost(box: Bbox, frame: Bbox, taken: list[Bbox], covered: npt.NDArray[np.float64]) -> float:
    area = box.width * box.height
    shared = (Bbox.intersection(box, other) for other in taken)
    names = sum(both.width * both.height for both in shared if both is not None) / area
    inside = Bbox.intersection(box, frame)
    outside = 1.0 if inside is None else 1.0 - inside.width * inside.height / area
    (x0, y0), (x1, y1) = box.get_points()
    x, y = covered.T
    points = np.count_nonzero((x0 <= x) & (x <= x1) & (y0 <= y) & (y <= y1))
    return NAME * names + EDGE * outside + POINT * float(points)
