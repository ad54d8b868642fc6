"""Areas on the earth: circles as polygons, and several inclusion areas as their intersection.

A vehicle must be in every inclusion area at once (PX4, and ArduPilot by default). The intersection
of two convex polygons is one polygon, found by clipping (Sutherland and Hodgman, 1974). If one is
not convex, the intersection may have several parts; this is refused, unless the other one contains
it completely.

All computations are in metres about a nearby point: degrees are not a plane, and longitudes jump at
the 180th meridian.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

from companion.geometry import GlobalOrigin, NorthEast, is_in_polygon
from companion.motion.polygons import do_overlap
from companion.plans.route_plan import ItemRefused, LatLon, PlanArea

SIDES = 32
"""Corners of the polygon that replaces a circle: 0.5 % of the radius smaller, or larger."""
STRAIGHT_M = 0.01
"""A corner this near to the line through its neighbours is none."""
MAX_RADIUS_M = 20_000.0


def circle(item: str, centre: LatLon, radius_m: float, is_inclusion: bool) -> tuple[LatLon, ...]:
    """The corners of a polygon inside a circle, or around it for an exclusion.

    Args:
        item: its name in messages.
        centre: degrees.
        radius_m: the radius of the circle.
        is_inclusion: whether the vehicle must stay inside.

    Raises:
        ItemRefused: there is no such circle.
    """
    if not 0 < radius_m <= MAX_RADIUS_M:
        raise ItemRefused(item, f"a circle of {radius_m:g} m", f"draw 0 to {MAX_RADIUS_M:g} m")
    reach_m = radius_m if is_inclusion else radius_m / math.cos(math.pi / SIDES)
    angles = (2 * math.pi * side / SIDES for side in range(SIDES))
    about = GlobalOrigin(*centre, 0.0)
    return tuple(_degrees(about, (reach_m * math.cos(a), reach_m * math.sin(a))) for a in angles)


def box(points: Sequence[LatLon], margin_m: float) -> tuple[LatLon, ...]:
    """The corners of a box around some points, with edges from south to north and west to east."""
    about = GlobalOrigin(*points[0], 0.0)
    local = [_local(about, point) for point in points]
    south, north = min(n for n, _ in local) - margin_m, max(n for n, _ in local) + margin_m
    west, east = min(e for _, e in local) - margin_m, max(e for _, e in local) + margin_m
    corners = ((south, west), (south, east), (north, east), (north, west))
    return tuple(_degrees(about, corner) for corner in corners)


def is_inside(point: LatLon, corners: Sequence[LatLon]) -> bool:
    """Whether a point lies inside an area.

    >>> is_inside((0.5, 180.0), [(0.0, 179.0), (0.0, -179.0), (1.0, -179.0), (1.0, 179.0)])
    True
    """
    about = GlobalOrigin(*point, 0.0)
    return is_in_polygon((0.0, 0.0), [_local(about, corner) for corner in corners])


def do_meet(one: Sequence[LatLon], other: Sequence[LatLon]) -> bool:
    """Whether two areas have a point in common."""
    about = GlobalOrigin(*one[0], 0.0)
    return do_overlap(*([_local(about, corner) for corner in area] for area in (one, other)))


def common(areas: Sequence[PlanArea]) -> PlanArea:
    """The intersection of some areas.

    Raises:
        ItemRefused: it is empty, or may have several parts.
    """
    about = GlobalOrigin(*areas[0].corners[0], 0.0)
    first, *others = areas
    shared = _drawn(first, about)
    for area in others:
        shared = _both(shared, _drawn(area, about), area.item)
    return replace(first, corners=tuple(_degrees(about, corner) for corner in shared))


def _drawn(area: PlanArea, about: GlobalOrigin) -> list[NorthEast]:
    """The corners at which an area turns, counterclockwise.

    An edge cut in two leaves a corner on a line, which rounding moves to either side. Only without
    such corners can it be decided whether an area is convex.
    """
    bends = _bends([_local(about, corner) for corner in area.corners])
    if len(bends) < 3:
        raise ItemRefused(area.item, "has no area: its corners lie on one line", "draw it anew")
    return bends if _area(bends) > 0 else bends[::-1]


def _bends(corners: Sequence[NorthEast]) -> list[NorthEast]:
    """The corners at which a polygon turns, only one of those that nearly coincide.

    Each corner is compared with its remaining neighbours, so one of two in the same place stays.
    """
    kept, index, passed = list(corners), 0, 0
    while len(kept) > 2 and passed < len(kept):
        before, corner, after = kept[index - 1], kept[index], kept[(index + 1) % len(kept)]
        width_m = math.dist(before, after)
        is_there = math.dist(before, corner) < STRAIGHT_M
        if is_there or abs(_side(before, after, corner)) <= STRAIGHT_M * width_m:
            del kept[index]
            index, passed = max(0, index - 1) % len(kept), 0
        else:
            index, passed = (index + 1) % len(kept), passed + 1
    return kept


def _both(one: list[NorthEast], other: list[NorthEast], item: str) -> list[NorthEast]:
    if _is_convex(other):
        clipped = _bends(_clipped(one, other))
        if _is_convex(one) or clipped == one:
            if len(clipped) < 3 or abs(_area(clipped)) < 1.0:
                raise ItemRefused(item, "nothing is inside it and the others", "remove one of them")
            return clipped
    if _is_convex(one) and _clipped(other, one) == other:
        return other
    advice = "draw one area, or convex ones"
    raise ItemRefused(item, "what is inside it and the others may have several parts", advice)


def _clipped(polygon: list[NorthEast], window: list[NorthEast]) -> list[NorthEast]:
    """The part of a polygon inside a convex one, which runs counterclockwise."""
    for a, b in pairwise([*window, window[0]]):
        kept: list[NorthEast] = []
        for p, q in pairwise([*polygon, *polygon[:1]]):
            inside_p, inside_q = _side(a, b, p), _side(a, b, q)
            if inside_p >= 0:
                kept.append(p)
            if (inside_p > 0 > inside_q) or (inside_p < 0 < inside_q):
                t = inside_p / (inside_p - inside_q)
                kept.append((p[0] + t * (q[0] - p[0]), p[1] + t * (q[1] - p[1])))
        polygon = kept
    return polygon


def _side(a: NorthEast, b: NorthEast, p: NorthEast) -> float:
    """Positive if p is to the left of the line from a to b, seen from above."""
    return (b[1] - a[1]) * (p[0] - a[0]) - (b[0] - a[0]) * (p[1] - a[1])


def _area(polygon: Sequence[NorthEast]) -> float:
    """Square metres; positive if it runs counterclockwise, seen from above."""
    return sum(_side((0, 0), a, b) for a, b in pairwise([*polygon, polygon[0]])) / 2


def is_counterclockwise(corners: Sequence[LatLon]) -> bool:
    """Whether the corners run counterclockwise, seen from above (right-hand rule of RFC 7946)."""
    about = GlobalOrigin(*corners[0], 0.0)
    return _area([_local(about, corner) for corner in corners]) > 0


def _is_convex(polygon: Sequence[NorthEast]) -> bool:
    """Whether a polygon without crossings, which runs counterclockwise, is convex."""
    corners = [*polygon, *polygon[:2]]
    return all(
        _side(a, b, c) >= 0 for a, b, c in zip(corners, corners[1:], corners[2:], strict=False)
    )


def _local(about: GlobalOrigin, point: LatLon) -> NorthEast:
    return about.to_local(*point, 0.0)[:2]


def _degrees(about: GlobalOrigin, point: NorthEast) -> LatLon:
    return about.to_global((*point, 0.0))[:2]
