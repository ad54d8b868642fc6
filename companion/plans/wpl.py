"""Text files of waypoints: QGC WPL 110, and the bare fence files of ArduPilot.

A line of WPL is `seq current frame command p1 p2 p3 p4 lat lon alt autocontinue`, separated by tabs
or blanks; lines may be comments (#). Item 0 is home if it is a waypoint above sea level, as
ArduPilot writes it. Fences and rally points saved as WPL are items too: p1 is the number of corners
at each corner of a polygon, and the radius of a circle. An older fence file has `lat lon` in each
line: first ArduPilot's return point, then the corners.
"""

from __future__ import annotations

import re
from itertools import takewhile

from companion.mavlink.framing import dialect
from companion.plans.areas import circle
from companion.plans.commands import CommandItem
from companion.plans.meanings import required, route_of
from companion.plans.route_plan import (
    ItemRefused,
    LatLon,
    PlanArea,
    RoutePlan,
    Waypoint,
    check_degrees,
    ring,
)

INCLUSIONS = frozenset(
    {
        dialect.MAV_CMD_NAV_FENCE_POLYGON_VERTEX_INCLUSION,
        dialect.MAV_CMD_NAV_FENCE_CIRCLE_INCLUSION,
    }
)
POLYGONS = frozenset(
    {
        dialect.MAV_CMD_NAV_FENCE_POLYGON_VERTEX_INCLUSION,
        dialect.MAV_CMD_NAV_FENCE_POLYGON_VERTEX_EXCLUSION,
    }
)
CIRCLES = frozenset(
    {
        dialect.MAV_CMD_NAV_FENCE_CIRCLE_INCLUSION,
        dialect.MAV_CMD_NAV_FENCE_CIRCLE_EXCLUSION,
    }
)
DRAWN = POLYGONS | CIRCLES | {dialect.MAV_CMD_NAV_RALLY_POINT}
"""Commands of fences and rally points; the others are flown."""
HEADER = re.compile(r"QGC WPL (\d+)\s*$")
COLUMNS = 12
MAX_LINES = 5000


def read_wpl(text: str, leave_out: frozenset[str]) -> RoutePlan:
    """The plan of a WPL file.

    Raises:
        ItemRefused, ItemsRefused: a mission cannot express it.
    """
    first, *lines = text.splitlines() or [""]
    version = HEADER.match(first)
    if version is None or version[1] != "110":
        raise ItemRefused("", "its first line is not QGC WPL 110", "save it as such")
    rows = [row for line in lines if (row := line.partition("#")[0].split())]
    if len(rows) > MAX_LINES:
        raise ItemRefused("", f"has {len(rows)} items, more than {MAX_LINES}")
    items = [_item(row) for row in rows]
    home: LatLon | None = None
    home_amsl_m, notes = None, list[str]()
    if items and items[0].number == "0" and items[0].command == 16 and items[0].frame == 0:
        home, home_amsl_m = items[0].position, items[0].params[6]
        items = items[1:]
    flown, drawn = list[CommandItem](), list[CommandItem]()
    for item in items:
        (drawn if item.command in DRAWN else flown).append(item)
    route = route_of(flown, leave_out, (item.number for item in drawn))
    left_out = [item for item in drawn if item.number in leave_out]
    notes += [f"{item.item}: {item.name} left out, as asked" for item in left_out]
    areas, rally = _drawn([item for item in drawn if item not in left_out])
    kind = "a file of waypoints (QGC WPL 110)"
    return route.plan(kind, home, home_amsl_m, tuple(notes), areas, rally)


def _drawn(items: list[CommandItem]) -> tuple[tuple[PlanArea, ...], tuple[Waypoint, ...]]:
    """The areas and rally points that these items draw."""
    areas, rally = list[PlanArea](), list[Waypoint]()
    while items:
        first = items[0]
        is_inclusion, radius_m = first.command in INCLUSIONS, first.param(1)
        shape, number = [first], len(areas) + 1
        if first.command == dialect.MAV_CMD_NAV_RALLY_POINT:
            name, height = f"R{len(rally) + 1}", first.height if first.param(7) > 0 else None
            rally.append(Waypoint(first.item, name, required(first), height))
        elif first.command in POLYGONS:
            shape = _polygon(items)
            item = f"items {first.number} to {shape[-1].number}"
            corners = ring(item, map(required, shape))
            areas.append(PlanArea(item, f"polygon_{number}", corners, is_inclusion))
        else:
            corners = circle(first.item, required(first), radius_m, is_inclusion)
            areas.append(PlanArea(first.item, f"circle_{number}", corners, is_inclusion))
        items = items[len(shape) :]
    return tuple(areas), tuple(rally)


def _polygon(items: list[CommandItem]) -> list[CommandItem]:
    """The corners of the polygon at the start of some items, as many as the first one says."""
    first, count = items[0], int(items[0].param(1))
    same = list(takewhile(lambda item: item.command == first.command, items))
    if not 0 < count <= len(same):
        what = f"says that its polygon has {count} corners, and {len(same)} are there"
        raise ItemRefused(first.item, what, "save the fence again")
    return same[:count]


def _item(row: list[str]) -> CommandItem:
    item = f"item {row[0][:20]}"
    if len(row) != COLUMNS:
        raise ItemRefused(item, f"has {len(row)} columns, expected {COLUMNS}", "correct the line")
    try:
        numbers = [float(word) for word in row]
        sequence, _, frame, command = (int(number) for number in numbers[:4])
    except (ValueError, OverflowError):
        raise ItemRefused(item, "has something that is not a number", "correct the line") from None
    if any(abs(number) > 1e9 for number in numbers if number == number):
        raise ItemRefused(item, "has a number that is too large", "correct the line")
    params = tuple(None if number != number else number for number in numbers[4:11])
    return CommandItem(str(sequence), command, frame, params, sequence)


def read_fence(text: str) -> RoutePlan:
    """The fence of a bare fence file.

    Raises:
        ItemRefused: it is no fence file.
    """
    points = []
    rows = [line.partition("#")[0].split() for line in text.splitlines()]
    for index, row in enumerate(row for row in rows if row):
        item = f"point {index + 1}"
        try:
            latitude, longitude = map(float, row)
        except ValueError:
            raise ItemRefused(item, "is not a latitude and a longitude") from None
        points.append(check_degrees(item, latitude, longitude))
    if len(points) < 4:
        raise ItemRefused("", "has no return point and three corners, so it is no fence")
    area = PlanArea("the fence", "fence", ring("the fence", points[1:]), is_inclusion=True)
    notes = "its return point is left out; the vehicle never leaves the fence"
    return RoutePlan("a fence of ArduPilot", areas=(area,), notes=(notes,))


def is_fence(text: str) -> bool:
    """Whether a text looks like a bare fence file."""
    lines = [line.partition("#")[0].split() for line in text.splitlines()[:50]]
    rows = [row for row in lines if row]
    return bool(rows) and all(len(row) == 2 and all(map(_is_number, row)) for row in rows)


def _is_number(word: str) -> bool:
    return re.fullmatch(r"[-+]?\d+(\.\d*)?", word) is not None
