"""Text files of waypoints: QGC WPL 110, and the bare fence files of ArduPilot.

A line of WPL is `seq current frame command p1 p2 p3 p4 lat lon alt autocontinue`, with tabs or
blanks between; lines may be comments (#). Item 0 is home where it is a waypoint above the sea, as
ArduPilot writes it. A fence file has `lat lon` in each line: where ArduPilot returns to, and then
the corners.
"""

from __future__ import annotations

import re

from companion.plans.commands import CommandItem
from companion.plans.meanings import route_of
from companion.plans.route_plan import (
    ItemRefused,
    LatLon,
    PlanArea,
    RoutePlan,
    check_degrees,
    ring,
)

HEADER = re.compile(r"QGC WPL (\d+)\s*$")
COLUMNS = 12
MAX_LINES = 5000


def read_wpl(text: str, leave_out: frozenset[str]) -> RoutePlan:
    """The plan of a WPL file.

    Raises:
        ItemRefused, ItemsRefused: a mission cannot mean it.
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
    home_amsl_m, told = None, list[str]()
    if items and items[0].number == "0" and items[0].command == 16 and items[0].frame == 0:
        home, home_amsl_m = items[0].position, items[0].params[6]
        items = items[1:]
    route = route_of(items, leave_out)
    return route.plan("a file of waypoints (QGC WPL 110)", home, home_amsl_m, tuple(told))


def _item(row: list[str]) -> CommandItem:
    item = f"item {row[0][:20]}"
    if len(row) != COLUMNS:
        raise ItemRefused(item, f"has {len(row)} columns, expected {COLUMNS}", "correct the line")
    try:
        numbers = [float(word) for word in row]
        sequence, _, frame, command = (int(number) for number in numbers[:4])
    except (ValueError, OverflowError):
        raise ItemRefused(item, "has something that is no number", "correct the line") from None
    if any(abs(number) > 1e9 for number in numbers if number == number):
        raise ItemRefused(item, "has a number that is too large", "correct the line")
    params = tuple(None if number != number else number for number in numbers[4:11])
    return CommandItem(str(sequence), command, frame, params, sequence)


def read_fence(text: str) -> RoutePlan:
    """The fence of a bare fence file.

    Raises:
        ItemRefused: it is none.
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
    told = "its return point is left out; the vehicle never leaves the fence"
    return RoutePlan("a fence of ArduPilot", areas=(area,), told=(told,))


def is_fence(text: str) -> bool:
    """Whether a text looks like a bare fence file."""
    lines = [line.partition("#")[0].split() for line in text.splitlines()[:50]]
    rows = [row for row in lines if row]
    return bool(rows) and all(len(row) == 2 and all(map(_is_number, row)) for row in rows)


def _is_number(word: str) -> bool:
    return re.fullmatch(r"[-+]?\d+(\.\d*)?", word) is not None
