"""Converts a fence to items of the mission protocol, and back.

1. Writing: polygons come first. PX4 misreads a polygon behind a circle: it takes each corner for
   the first corner of another polygon.
2. Reading: items are interpreted as PX4 interprets them, and a flaw that PX4 does not report is
   named. PX4 compares longitudes as they are, so a polygon across the 180th meridian, from 179.9 to
   -179.9 degrees, contains nothing there.

Source: PX4 1.16, src/modules/navigator/geofence.cpp (_updateFence).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

from companion.geofence import FenceArea, FenceCircle, FencePolygon, StoredFence
from companion.geometry import NorthEast
from companion.mavlink.framing import dialect
from companion.mavlink.item_transfer import StoredItem

_POLYGONS = {5001: True, 5002: False}
_CIRCLES = {5003: True, 5004: False}
"""MAV_CMD -> whether the area is one of inclusion."""
_RETURN_POINT = 5000
_HALF_TURN = 180 * 10**7
"""Degrees of longitude, as items count them."""
_COMMANDS = {
    (FencePolygon, True): 5001,
    (FencePolygon, False): 5002,
    (FenceCircle, True): 5003,
    (FenceCircle, False): 5004,
}

OnEarth = Callable[[NorthEast], tuple[float, float] | None]
"""Latitude and longitude of a point in the mission's frame."""
FromEarth = Callable[[float, float], NorthEast | None]
"""The reverse of `OnEarth`."""


def items_of(
    areas: Sequence[FenceArea], on_earth: OnEarth, first: int = 0
) -> tuple[StoredItem, ...] | None:
    """The items of a fence; None while its place on the earth is not known.

    Args:
        areas: in the mission's frame.
        on_earth: converts a point of that frame.
        first: index of the corner with which each polygon begins.
    """
    items: list[StoredItem] = []
    for area in sorted(areas, key=lambda each: isinstance(each.shape, FenceCircle)):
        shape, points = area.shape, tuple[NorthEast, ...]()
        command = _COMMANDS[type(shape), area.is_inclusion]
        if isinstance(shape, FenceCircle):
            points, number = (shape.centre,), shape.radius_m
        else:
            at = first % len(shape.corners)
            points, number = (*shape.corners[at:], *shape.corners[:at]), float(len(shape.corners))
        for point in points:
            if (there := on_earth(point)) is None:
                return None
            x, y = (round(degrees * 1e7) for degrees in there)
            items.append(StoredItem(command, dialect.MAV_FRAME_GLOBAL, number, x, y))
    return tuple(items)


def fence_of(items: Sequence[StoredItem], from_earth: FromEarth) -> StoredFence | None:
    """The fence that PX4 makes of items; None while their place is not known.

    Args:
        items: of a fence, as read from the autopilot.
        from_earth: converts a place on the earth to the mission's frame.
    """
    points: list[NorthEast] = []
    for item in items:
        if (point := from_earth(item.x / 1e7, item.y / 1e7)) is None:
            return None
        points.append(point)
    areas: list[FenceArea] = []
    flaw: str | None = None
    has_circle, at = False, 0
    while at < len(items):
        item, count = items[at], 1
        if item.command in _CIRCLES:
            has_circle = True
            areas.append(FenceArea(FenceCircle(points[at], _number(item)), _CIRCLES[item.command]))
        elif item.command in _POLYGONS:
            corners = max(int(_number(item)), 1)
            is_whole = at + corners <= len(items)
            is_across = _is_across_180(items[at : at + corners])
            is_sound = is_whole and not is_across
            shape = FencePolygon(tuple(points[at : at + corners]) if is_sound else ())
            areas.append(FenceArea(shape, _POLYGONS[item.command]))
            count = 1 if has_circle else corners
            if has_circle:
                flaw = "a circle stands before a polygon, and PX4 misreads what follows it"
            elif not is_whole:
                flaw = "a polygon is not whole"
            elif is_across:
                flaw = "a polygon crosses the 180th meridian, where PX4 takes it for another one"
        elif item.command != _RETURN_POINT:
            flaw = f"it has an item of the command {item.command}"
        at += count
    return StoredFence(tuple(areas), len(items), flaw)


def _is_across_180(corners: Sequence[StoredItem]) -> bool:
    """Whether a polygon lies on both sides of the 180th meridian."""
    longitudes = [corner.y for corner in corners]
    return max(longitudes) - min(longitudes) > _HALF_TURN


def _number(item: StoredItem) -> float:
    return item.first if math.isfinite(item.first) else 0.0
