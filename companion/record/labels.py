"""Names beside points, where they cover each other and the drawing the least.

Each name has eight places around its point, and eight further away; they are tried in the usual
order, right and above first, and the one that covers least is taken (Christensen, Marks and
Shieber, An empirical study of algorithms for point-feature label placement, ACM Transactions on
Graphics 14, 1995).
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.font_manager import FontProperties
from matplotlib.textpath import TextPath
from matplotlib.transforms import Bbox

GAPS = (4.0, 16.0)
"""Between a point and its name, in 1/72 inch; so are all lengths here."""
AROUND = ((1, 1), (1, -1), (-1, 1), (-1, -1), (1, 0), (-1, 0), (0, 1), (0, -1))
SIZE, HEIGHT = 9.0, 12.0
NAME, EDGE, POINT = 100.0, 40.0, 1.0
"""How bad it is to cover all of another name, to leave the panel, and to cover a point."""


def write_names(
    axis: Axes,
    names: Mapping[str, tuple[float, float]],
    drawn: npt.NDArray[np.float64],
) -> None:
    """Writes names into a panel that is laid out.

    Args:
        axis: the panel.
        names: each with its point.
        drawn: (n, 2) points of lines that are better not covered; as the names' in data units.
    """
    per_point = axis.figure.dpi / 72.0
    to_points = axis.transData.transform
    panel = axis.get_window_extent()
    frame = Bbox(panel.get_points() / per_point)
    anchors = {name: to_points(point) / per_point for name, point in names.items()}
    covered = np.vstack([to_points(drawn.reshape(-1, 2)) / per_point, *anchors.values()])
    taken: list[Bbox] = []
    for name, anchor in anchors.items():
        outline = TextPath((0, 0), name, prop=FontProperties(size=SIZE)).get_extents()
        size = outline.width + 2.0, HEIGHT
        boxes = [_box(anchor, size, gap, side) for gap in GAPS for side in AROUND]
        costs = [_cost(box, frame, taken, covered) for box in boxes]
        best = boxes[costs.index(min(costs))]
        taken.append(best)
        written = axis.annotate(
            name,
            names[name],
            xytext=(best.x0 + 1.0 - anchor[0], best.y0 - anchor[1]),
            textcoords="offset points",
            fontsize=SIZE,
            verticalalignment="bottom",
            bbox={"boxstyle": "square,pad=0", "facecolor": "white", "alpha": 0.6, "linewidth": 0},
        )
        written.set_in_layout(False)


def _box(
    anchor: npt.NDArray[np.float64], size: tuple[float, float], gap: float, side: tuple[int, int]
) -> Bbox:
    """Where a name lies on one side of its point."""
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
