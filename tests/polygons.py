"""Polygons by other means than the program's: clipped to squares, and drawn at random."""

from __future__ import annotations

import math
from collections.abc import Sequence

from hypothesis import strategies as st

Point = tuple[float, float]


def area_in_box(polygon: Sequence[Point], low: Point, high: Point) -> float:
    """Area of the part of a polygon in a box (Sutherland and Hodgman 1974, then the shoelace)."""
    part = list(polygon)
    for axis in (0, 1):
        for sign, limit in ((1.0, high[axis]), (-1.0, -low[axis])):
            part = _clipped(part, axis, sign, limit)
    return abs(_doubled_area(part)) / 2


def _clipped(polygon: list[Point], axis: int, sign: float, limit: float) -> list[Point]:
    kept: list[Point] = []
    for i, point in enumerate(polygon):
        before = polygon[i - 1]
        beyond, beyond_before = sign * point[axis] - limit, sign * before[axis] - limit
        if (beyond > 0) != (beyond_before > 0):
            share = beyond_before / (beyond_before - beyond)
            x, y = (b + share * (p - b) for b, p in zip(before, point, strict=True))
            kept.append((x, y))
        if beyond <= 0:
            kept.append(point)
    return kept


def _doubled_area(polygon: list[Point]) -> float:
    return sum(
        polygon[i - 1][0] * point[1] - point[0] * polygon[i - 1][1]
        for i, point in enumerate(polygon)
    )


@st.composite
def stars(draw: st.DrawFn, middle: Point, least_m: float, most_m: float) -> list[Point]:
    """Simple polygons about a point, hardly ever convex: corners at rising angles."""
    count = draw(st.integers(3, 9))
    lengths = draw(st.lists(st.floats(least_m, most_m), min_size=count, max_size=count))
    turn = draw(st.floats(0.0, 2 * math.pi))
    angles = [turn + 2 * math.pi * i / count for i in range(count)]
    return [
        (middle[0] + length * math.cos(angle), middle[1] + length * math.sin(angle))
        for length, angle in zip(lengths, angles, strict=True)
    ]
