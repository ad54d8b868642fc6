"""The gate's own geometry: points and polygons in the plane, metres north and east.

The gate shares it with none of the code that it monitors.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

Corner = tuple[float, float]
"""North, east; metres."""


def is_inside_of(point: Corner, fence: Sequence[Corner], margin_m: float) -> bool:
    """Whether a point is inside a polygon, at least a margin from its edges (ray casting
    eastwards).
    """
    north, east = point
    is_odd = False
    for (n1, e1), (n2, e2) in edges(fence):
        if _distance(point, (n1, e1), (n2, e2)) < margin_m:
            return False
        if (n1 > north) != (n2 > north) and east < e1 + (north - n1) / (n2 - n1) * (e2 - e1):
            is_odd = not is_odd
    return is_odd


def distance_to(point: Corner, zone: Sequence[Corner]) -> float:
    """Distance from a point to the nearest edge of a polygon, metres; negative inside."""
    nearest_m = min(_distance(point, *edge) for edge in edges(zone))
    return -nearest_m if is_inside_of(point, zone, 0.0) else nearest_m


def edges(polygon: Sequence[Corner]) -> Sequence[tuple[Corner, Corner]]:
    """The edges of a polygon, each as a pair of corners."""
    return [*zip(polygon, (*polygon[1:], polygon[0]), strict=True)]


def is_crossing(a: Corner, b: Corner, c: Corner, d: Corner) -> bool:
    """Whether the segments a-b and c-d cross."""
    return _side(a, b, c) * _side(a, b, d) < 0 and _side(c, d, a) * _side(c, d, b) < 0


def _side(a: Corner, b: Corner, point: Corner) -> float:
    """Positive on one side of the line through a and b, negative on the other."""
    return (b[0] - a[0]) * (point[1] - a[1]) - (b[1] - a[1]) * (point[0] - a[0])


def _distance(point: Corner, start: Corner, end: Corner) -> float:
    """Distance from a point to a segment, metres."""
    along = (end[0] - start[0], end[1] - start[1])
    length_2 = along[0] ** 2 + along[1] ** 2
    offset = (point[0] - start[0]) * along[0] + (point[1] - start[1]) * along[1]
    share = min(max(offset / length_2, 0.0), 1.0) if length_2 else 0.0
    return math.dist(point, (start[0] + share * along[0], start[1] + share * along[1]))
