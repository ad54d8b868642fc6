"""The items of the mission protocol: parsing, checking, conversion.

A `WireItem` is an item as it was sent, without the differences between the two messages: places in
degrees, frames without `_INT`, None for NaN (or INT32_MAX: "not given"). A download returns it.
`check_item` gives PX4's answer to it. `item_from`, `areas_from` and `safe_points_from` convert
items into missions, fences and rally points of the autopilot.

Source: https://mavlink.io/en/services/mission.html; PX4 1.16, src/modules/mavlink/
mavlink_mission.cpp: which command is accepted in which frame. Left out: commands of VTOLs.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from enum import IntEnum

from companion.geofence import FenceArea, FenceCircle, FencePolygon
from companion.geometry import GlobalOrigin, NorthEast
from companion.mavlink.framing import Message, dialect
from sitl.autopilot.mission_items import MissionItem
from sitl.autopilot.return_destination import SafePoint

GLOBAL, MISSION, RELATIVE = 0, 2, 3  # MAV_FRAME
WITHOUT_INT = {5: GLOBAL, 6: RELATIVE}
WITH_INT = {GLOBAL: 5, RELATIVE: 6}
INT32_MIN, INT32_MAX = -(2**31), 2**31 - 1


class MissionType(IntEnum):
    """MAV_MISSION_TYPE."""

    MISSION = 0
    FENCE = 1
    RALLY = 2


@dataclass(frozen=True, slots=True)
class WireItem:
    """An item as it was sent.

    Attributes:
        frame: GLOBAL, RELATIVE or MISSION; any other is refused.
        parameters: param1 to param4.
        x: latitude in degrees, or param5 in the frame MISSION.
        y: longitude in degrees, or param6.
        z: altitude in metres, or param7.
    """

    command: int
    frame: int
    parameters: tuple[float | None, float | None, float | None, float | None]
    x: float | None
    y: float | None
    z: float | None
    autocontinue: bool

    @property
    def is_global(self) -> bool:
        """Whether it has a place on the earth."""
        return self.frame in (GLOBAL, RELATIVE)


def wire_item(message: Message) -> WireItem:
    """The item in a MISSION_ITEM_INT or MISSION_ITEM."""
    frame, x, y = message.frame, message.x, message.y
    if message.get_type() == "MISSION_ITEM_INT":
        frame = WITHOUT_INT.get(frame, frame)
        scale = 1.0 if frame == MISSION else 1e7
        x, y = (math.nan if value == INT32_MAX else value / scale for value in (x, y))
    first, second, third, fourth = (
        _given(value) for value in (message.param1, message.param2, message.param3, message.param4)
    )
    return WireItem(
        message.command,
        frame,
        (first, second, third, fourth),
        _given(x),
        _given(y),
        _given(message.z),
        bool(message.autocontinue),
    )


def int_message(
    item: WireItem, seq: int, target: tuple[int, int], kind: MissionType, is_current: bool
) -> Message:
    """MISSION_ITEM_INT."""
    scale = 1e7 if item.is_global else 1.0
    x, y = (INT32_MAX if v is None else _int32(v * scale) for v in (item.x, item.y))
    frame = WITH_INT.get(item.frame, item.frame)
    return dialect.MAVLink_mission_item_int_message(
        *target, seq, frame, *_rest(item, is_current), x, y, _or_nan(item.z), kind
    )


def float_message(
    item: WireItem, seq: int, target: tuple[int, int], kind: MissionType, is_current: bool
) -> Message:
    """MISSION_ITEM, for clients that request it with MISSION_REQUEST."""
    x, y, z = map(_or_nan, (item.x, item.y, item.z))
    return dialect.MAVLink_mission_item_message(
        *target, seq, item.frame, *_rest(item, is_current), x, y, z, kind
    )


_PLACES = frozenset({16, 17, 19, 21, 22, 80, 195, 201})
_ACTIONS = (
    frozenset({20, 80, 93, 112, 114, 177, 178, 179, 187, 189, 196, 197, 200, 201, 203, 204, 205})
    | frozenset({206, 211, 214, 260, 530, 531, 532, 534, 1000, 1001, 2000, 2001, 2003, 2500, 2501})
    | frozenset({42600})
)
_RETURN_POINT, _RALLY_POINT = 5000, 5100
_POLYGONS = {5001: True, 5002: False}
_CIRCLES = {5003: True, 5004: False}
"""MAV_CMD of a circle -> whether it is an area of inclusion."""

COMMANDS: dict[tuple[MissionType, bool], frozenset[int]] = {
    (MissionType.MISSION, True): _PLACES,
    (MissionType.MISSION, False): _ACTIONS,
    (MissionType.FENCE, True): frozenset({_RETURN_POINT, *_POLYGONS, *_CIRCLES}),
    (MissionType.RALLY, True): frozenset({_RALLY_POINT}),
}
"""Kind of plan, and whether the item has a place -> accepted MAV_CMDs."""


def check_item(kind: MissionType, item: WireItem) -> int:
    """MAV_MISSION_RESULT of an item."""
    if not (item.is_global or item.frame == MISSION):
        return int(dialect.MAV_MISSION_UNSUPPORTED_FRAME)
    if item.command not in COMMANDS.get((kind, item.is_global), frozenset()):
        return int(dialect.MAV_MISSION_UNSUPPORTED)
    if item.is_global:
        needs_place = kind is not MissionType.MISSION
        if not _is_angle(item.x, 90.0, needs_place):
            return int(dialect.MAV_MISSION_INVALID_PARAM5_X)
        if not _is_angle(item.y, 180.0, needs_place):
            return int(dialect.MAV_MISSION_INVALID_PARAM6_Y)
    first = item.parameters[0] or 0.0
    if item.command in _POLYGONS and first < 3:
        return int(dialect.MAV_MISSION_ERROR)  # too few corners
    if item.command in _CIRCLES and first <= 0:
        return int(dialect.MAV_MISSION_INVALID_PARAM1)
    return int(dialect.MAV_MISSION_ACCEPTED)


def item_from(item: WireItem, origin: GlobalOrigin) -> MissionItem:
    """An accepted item of a mission, as the autopilot flies it."""
    is_above_home = item.frame == RELATIVE
    up_m = item.z if is_above_home or item.z is None else item.z - origin.altitude_m
    place = _place(item, origin) if item.is_global else None
    return MissionItem(item.command, item.parameters, place, up_m, is_above_home, item.autocontinue)


def safe_points_from(items: Sequence[WireItem], origin: GlobalOrigin) -> tuple[SafePoint, ...]:
    """The rally points of accepted items."""
    points = []
    for item in items:
        is_above_home, z = item.frame == RELATIVE, item.z or 0.0
        up_m = z if is_above_home else z - origin.altitude_m
        points.append(SafePoint(_place(item, origin) or (0.0, 0.0), up_m, is_above_home))
    return tuple(points)


def areas_from(items: Sequence[WireItem], origin: GlobalOrigin) -> list[FenceArea]:
    """The fence areas of accepted items, as PX4 reads them.

    Polygons have to come first. After a circle PX4 continues item by item, so each corner of a
    polygon begins a polygon of its own with as many of the following items. A polygon that extends
    beyond the last item contains nothing. Nor does one across the 180th meridian, at places near
    it: PX4 compares longitudes as they are.
    """
    areas: list[FenceArea] = []
    points = [_place(item, origin) or (0.0, 0.0) for item in items]
    at, has_circle = 0, False
    while at < len(items):
        item, count = items[at], 1
        number = item.parameters[0] or 0.0
        if item.command in _CIRCLES:
            has_circle = True
            circle = FenceCircle(points[at], number)
            areas.append(FenceArea(circle, _CIRCLES[item.command]))
        elif item.command in _POLYGONS:
            drawn = slice(at, at + int(number))
            corners = tuple(points[drawn])
            is_sound = len(corners) == int(number) and not _is_across_180(items[drawn])
            polygon = FencePolygon(corners if is_sound else ())
            areas.append(FenceArea(polygon, _POLYGONS[item.command]))
            count = 1 if has_circle else int(number)
        at += count
    return areas


def _is_across_180(corners: Sequence[WireItem]) -> bool:
    longitudes = [corner.y or 0.0 for corner in corners]
    return max(longitudes) - min(longitudes) > 180.0


def _place(item: WireItem, origin: GlobalOrigin) -> NorthEast | None:
    if item.x is None or item.y is None:
        return None
    return origin.to_local(item.x, item.y, 0.0)[:2]


def _rest(item: WireItem, is_current: bool) -> tuple[float, ...]:
    """The fields from command to param4, in the order of both messages."""
    parameters = map(_or_nan, item.parameters)
    return (item.command, int(is_current), int(item.autocontinue), *parameters)


def _is_angle(value: float | None, limit_deg: float, is_needed: bool) -> bool:
    return not is_needed if value is None else abs(value) <= limit_deg


def _given(value: float) -> float | None:
    return value if math.isfinite(value) else None


def _or_nan(value: float | None) -> float:
    return math.nan if value is None else value


def _int32(value: float) -> int:
    return max(INT32_MIN, min(INT32_MAX, round(value)))
