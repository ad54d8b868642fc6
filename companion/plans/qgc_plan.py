"""Plans of QGroundControl: .plan files, and the .mission files of its first versions.

Read as QGC reads them (src/MissionManager): an item has seven params, or four and a coordinate, or
param1 to param4 and a coordinate. The flown altitude is the seventh param in the item's `frame`;
AltitudeMode is what the user saw, and its numbers have changed over the years. Like QGC, this
reader ignores fences and rally points of other versions than 2, but adds a note.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from companion.plans.areas import circle
from companion.plans.commands import AMSL_FRAMES, CommandItem, PlannedRoute
from companion.plans.json_text import JsonObject, number, numbers, read_json
from companion.plans.meanings import route_of
from companion.plans.route_plan import (
    SAME_M,
    Height,
    ItemRefused,
    LatLon,
    PlanArea,
    RoutePlan,
    Waypoint,
    check_degrees,
    ring,
)

COPTERS = frozenset({0, 2, 3, 4, 13, 14, 15, 29, 35})
"""MAV_TYPEs of vehicles that hover; 0 is generic."""
RELATIVE_MODE, ABOVE_SEA_MODE = 1, 2
SURVEYS = {"survey": 5, "CorridorScan": 2}
"""Complex items that are flown point by point -> the newest known version of each."""


def read_plan(text: str, leave_out: frozenset[str]) -> RoutePlan:
    """The plan of a .plan or .mission file.

    Args:
        text: the text of the file.
        leave_out: numbers of items.

    Raises:
        ItemRefused, ItemsRefused: a mission cannot express it.
    """
    file = JsonObject(read_json(text), "")
    if "MAV_AUTOPILOT" in file or ("items" in file and "fileType" not in file):
        return _old_mission(file, leave_out)
    kind = file.text("fileType")
    if kind != "Plan":
        raise ItemRefused(
            "", f"is not a plan: its fileType is {kind[:40]!r}", "save it in QGC again"
        )
    _check_version(file, "the file", 1)
    mission = file.object("mission")
    _check_version(mission, "its mission", 2)
    _check_vehicle(mission)
    home, home_amsl_m = _home(mission.list("plannedHomePosition"))
    notes: list[str] = []
    route = _route(mission.list("items"), leave_out, notes)
    if not route.speeds_mps and "hoverSpeed" in mission:
        route.speeds_mps.append(mission.number("hoverSpeed"))
    areas, rally = _areas(file, notes), _rally(file, notes)
    kind = "a plan of QGroundControl"
    return route.plan(kind, home, home_amsl_m, tuple(notes), areas, rally)


def _old_mission(file: JsonObject, leave_out: frozenset[str]) -> RoutePlan:
    """The plan of a .mission file."""
    if "complexItems" in file and file.list("complexItems"):
        raise ItemRefused("", "has complex items of an old version", "open and save it in QGC")
    notes: list[str] = []
    route = _route(file.list("items"), leave_out, notes)
    if isinstance(file.data.get("plannedHomePosition"), dict):  # the first version
        file = JsonObject(
            {"plannedHomePosition": file.object("plannedHomePosition").list("coordinate")}, ""
        )
    home, home_amsl_m = _home(file.list("plannedHomePosition"))
    return route.plan("an old mission of QGroundControl", home, home_amsl_m, tuple(notes))


def _check_version(fields: JsonObject, name: str, known: int) -> None:
    version = fields.integer("version")
    if version != known:
        what = f"{name} has version {version}, and {known} is known"
        raise ItemRefused("", what, "open and save it in QGroundControl")


def _check_vehicle(mission: JsonObject) -> None:
    if "vehicleType" in mission and mission.integer("vehicleType") not in COPTERS:
        what = (
            f"is for a vehicle that is not a copter (vehicleType {mission.integer('vehicleType')})"
        )
        raise ItemRefused("", what, "make a plan for a multirotor")


def _home(listed: list[Any]) -> tuple[LatLon | None, float | None]:
    """The planned home, and its height above sea level; None if unknown."""
    latitude, longitude = numbers(listed[:2], "the planned home", "its position", 2)
    if latitude == longitude == 0:
        return None, None
    amsl_m = listed[2] if listed[2:] else None
    height = None if amsl_m is None else number(amsl_m, "the planned home", "its altitude")
    return check_degrees("the planned home", latitude, longitude), height


# -- items -----------------------------------------------------------------------------------------


def _route(entries: list[Any], leave_out: frozenset[str], notes: list[str]) -> PlannedRoute:
    """The route of the items, which are numbered from 1."""
    numbers = map(str, range(1, len(entries) + 1))
    return route_of(_items(entries, leave_out, notes), leave_out, numbers)


def _items(
    entries: list[Any], leave_out: frozenset[str], notes: list[str]
) -> Iterator[CommandItem]:
    for index, entry in enumerate(entries, 1):
        fields = JsonObject(entry, f"item {index}")
        kind = fields.text("type") if "type" in fields else "SimpleItem"
        if kind == "ComplexItem" and str(index) in leave_out:
            notes.append(f"{fields.item}: {fields.text('complexItemType')[:40]} left out, as asked")
        elif kind == "ComplexItem":
            yield from _survey(fields, index, notes)
        elif kind in ("SimpleItem", "missionItem"):
            yield _simple(fields, str(index), notes)
        else:
            raise ItemRefused(fields.item, f"is of the unknown type {kind[:40]!r}")


def _simple(fields: JsonObject, name: str, notes: list[str]) -> CommandItem:
    params = _params(fields)
    for key in ("doJumpId", "id"):
        if key in fields:
            jump_id = fields.integer(key)
            break
    else:
        jump_id = int(name.split(".")[0])
    item = CommandItem(name, fields.integer("command"), fields.integer("frame"), params, jump_id)
    if "AltitudeMode" in fields and item.position is not None:
        notes.extend(_doubts(fields, item))
    return item


def _doubts(fields: JsonObject, item: CommandItem) -> Iterator[str]:
    """Notes where the altitude that the user saw is not the one that the autopilot gets."""
    mode, is_amsl = fields.integer("AltitudeMode"), item.frame in AMSL_FRAMES
    if mode not in (RELATIVE_MODE, ABOVE_SEA_MODE):
        return
    words = ["above home", "above the sea"][is_amsl]
    if (mode == ABOVE_SEA_MODE) != is_amsl:
        yield (
            f"{item.item}: AltitudeMode {mode} and frame {item.frame} disagree; "
            f"the frame counts, so the altitude is {words}"
        )
    sent_m = item.param(7)
    if "Altitude" in fields and abs(fields.number("Altitude") - sent_m) > SAME_M:
        shown = f"Altitude {fields.number('Altitude'):g} and the seventh param {sent_m:g} disagree"
        yield f"{item.item}: {shown}; the param counts, so it is {sent_m:g} m {words}"


def _params(fields: JsonObject) -> tuple[float | None, ...]:
    """The seven params, in any version of the item."""
    if "params" in fields:
        listed = fields.list("params")
    else:
        listed = [fields.number(f"param{i}") if f"param{i}" in fields else 0 for i in range(1, 5)]
    if len(listed) == 4:
        listed = [*listed, *fields.list("coordinate")]
    if len(listed) != 7:
        raise ItemRefused(fields.item, f"has {len(listed)} params, expected 7")
    params = (None if p is None else number(p, fields.item, "a param") for p in listed)
    return tuple(params)


def _survey(fields: JsonObject, index: int, notes: list[str]) -> Iterator[CommandItem]:
    """The points of a survey, as QGC has computed them."""
    kind = fields.text("complexItemType")
    leave_out = f"leave it out: --leave-out {index}"
    known = SURVEYS.get(kind)
    if known is None:
        what = f"{kind[:40]} is not flown point by point in the file"
        raise ItemRefused(fields.item, what, f"make waypoints of it, or {leave_out}")
    version = fields.integer("version")
    if not 1 < version <= known:
        what = f"{kind} has version {version}, and up to {known} is known"
        raise ItemRefused(fields.item, what, f"open and save it in QGroundControl, or {leave_out}")
    style = fields.object("TransectStyleComplexItem")
    flown = style.list("Items") if "Items" in style else []
    if flown:
        for number_, entry in enumerate(flown, 1):
            yield _simple(JsonObject(entry, f"item {index}.{number_}"), f"{index}.{number_}", notes)
        return
    points = style.list("VisualTransectPoints") if "VisualTransectPoints" in style else []
    if not points:
        what = f"{kind} has no points: QGroundControl has not worked it out"
        raise ItemRefused(fields.item, what, f"open and save it in QGroundControl, or {leave_out}")
    camera = style.object("CameraCalc")
    if not _is_above_home(style, camera):
        what = f"{kind} has no altitude above home: it is above the sea, or follows the terrain"
        raise ItemRefused(fields.item, what, "open and save it in QGroundControl")
    up_m = camera.number("DistanceToSurface")
    notes.append(f"{fields.item}: its points alone; when to take a picture is not in the file")
    for number_, point in enumerate(points, 1):
        latitude, longitude = numbers(point, fields.item, "a point", 2)[:2]
        params = (0.0, 0.0, 0.0, None, latitude, longitude, up_m)
        yield CommandItem(f"{index}.{number_}", 16, 3, params, index)


def _is_above_home(style: JsonObject, camera: JsonObject) -> bool:
    """Whether the distance to the surface is an altitude above home; by the older or newer keys."""
    if "FollowTerrain" in style and style.flag("FollowTerrain"):
        return False
    if "DistanceMode" in camera:
        return camera.integer("DistanceMode") == RELATIVE_MODE
    return camera.flag("DistanceToSurfaceRelative")


# -- fence and rally points ------------------------------------------------------------------------


def _areas(file: JsonObject, notes: list[str]) -> tuple[PlanArea, ...]:
    """The areas of the fence."""
    fence = file.object("geoFence")
    if "version" not in fence or fence.integer("version") != 2:
        if any(key in fence and fence.list(key) for key in ("polygon", "polygons", "circles")):
            notes.append("fence: of a version that QGroundControl ignores; left out")
        return ()
    areas = []
    for index, entry in enumerate(fence.list("polygons"), 1):
        one = JsonObject(entry, f"fence polygon {index}")
        corners = (_corner(corner, one.item) for corner in one.list("polygon"))
        name = f"polygon_{index}"
        areas.append(PlanArea(one.item, name, ring(one.item, corners), one.flag("inclusion")))
    for index, entry in enumerate(fence.list("circles"), 1):
        one = JsonObject(entry, f"fence circle {index}")
        about = one.object("circle")
        centre, radius_m = _corner(about.list("center"), one.item), about.number("radius")
        is_inclusion = one.flag("inclusion")
        corners_of = circle(one.item, centre, radius_m, is_inclusion)
        areas.append(PlanArea(one.item, f"circle_{index}", corners_of, is_inclusion))
    if "breachReturn" in fence:
        notes.append("fence: its return point is left out; the vehicle never leaves the fence")
    return tuple(areas)


def _corner(value: object, item: str) -> LatLon:
    latitude, longitude = numbers(value, item, "a corner", 2)[:2]
    return check_degrees(item, latitude, longitude)


def _rally(file: JsonObject, notes: list[str]) -> tuple[Waypoint, ...]:
    if "rallyPoints" not in file:
        return ()
    rally = file.object("rallyPoints")
    points = rally.list("points") if "points" in rally else []
    if "version" not in rally or rally.integer("version") != 2:
        if points:
            notes.append("rally points: of a version that QGroundControl ignores; left out")
        return ()
    found = []
    for index, point in enumerate(points, 1):
        item = f"rally point {index}"
        latitude, longitude, *up_m = numbers(point, item, "its position", 2)
        height = Height(up_m[0]) if up_m and up_m[0] > 0 else None
        found.append(Waypoint(item, f"R{index}", check_degrees(item, latitude, longitude), height))
    return tuple(found)
