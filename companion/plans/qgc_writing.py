"""Writes a drawing as a .plan of QGroundControl, for display.

The prefix becomes a takeoff and waypoints. A loop becomes an endless jump. A plan that ends at rest
returns, or lands where it is. Safe places become rally points on the ground; if uploaded, they
change where the autopilot returns to, as a flight of the mission would.

Source: as qgc_plan.py; MAVSDK's importer asks for `type`, `frame` and seven params.
"""

from __future__ import annotations

import json
from typing import Any

from companion.mavlink.framing import dialect
from companion.plans.drawing import Drawing, DrawnVisit
from companion.plans.route_plan import LatLon

PX4, QUADROTOR = 12, 2
MIXED, RELATIVE, AMSL = 0, 1, 2
"""AltitudeMode."""


def plan_text(drawing: Drawing) -> str:
    """The text of a .plan file."""
    home = drawing.places[drawing.start]
    inclusion = [_polygon(drawing.fence, True)]
    exclusions = [_polygon(zone, False) for zone in drawing.keep_out.values()]
    plan = {
        "fileType": "Plan",
        "version": 1,
        "groundStation": "QGroundControl",
        "mission": {
            "version": 2,
            "firmwareType": PX4,
            "vehicleType": QUADROTOR,
            "cruiseSpeed": 15,
            "hoverSpeed": drawing.speed_mps or 5,
            "globalPlanAltitudeMode": MIXED,
            "plannedHomePosition": [*home.position, drawing.home_amsl_m],
            "items": _items(drawing),
        },
        "geoFence": {"version": 2, "polygons": inclusion + exclusions, "circles": []},
        "rallyPoints": {"version": 2, "points": [_rally(drawing, name) for name in drawing.safe]},
    }
    return json.dumps(plan, indent=4, allow_nan=False) + "\n"


def _rally(drawing: Drawing, name: str) -> list[float]:
    """A rally point, at the altitude of the ground, above home."""
    return [*drawing.places[name].position, 0.0]


def _polygon(corners: tuple[LatLon, ...], is_inclusion: bool) -> dict[str, Any]:
    listed = [list(corner) for corner in corners]
    return {"inclusion": is_inclusion, "polygon": listed, "version": 1}


def _items(drawing: Drawing) -> list[dict[str, Any]]:
    """The items, numbered from 1, as jumps count."""
    if not drawing.is_planned:
        return []
    items = [_at(drawing, DrawnVisit(drawing.start), dialect.MAV_CMD_NAV_TAKEOFF)]
    visits = list(drawing.prefix)
    ends_home = not drawing.loop and (not visits or visits[-1].place == drawing.start)
    if visits and ends_home and not visits[-1].hold_s:
        del visits[-1]
    items += [_at(drawing, visit) for visit in visits]
    if drawing.loop:
        first = len(items) + 1
        items += [_at(drawing, visit) for visit in drawing.loop]
        items.append(_do(dialect.MAV_CMD_DO_JUMP, first, -1))
    elif ends_home:
        items.append(_do(dialect.MAV_CMD_NAV_RETURN_TO_LAUNCH))
    else:
        latitude, longitude = drawing.places[visits[-1].place].position
        landing = _do(dialect.MAV_CMD_NAV_LAND)
        landing |= {"frame": dialect.MAV_FRAME_GLOBAL_RELATIVE_ALT}
        landing["params"] = [0, 0, 0, None, latitude, longitude, 0]
        items.append(landing)
    return [item | {"doJumpId": number} for number, item in enumerate(items, 1)]


def _at(
    drawing: Drawing, visit: DrawnVisit, command: int = dialect.MAV_CMD_NAV_WAYPOINT
) -> dict[str, Any]:
    """An item at a place."""
    place = drawing.places[visit.place]
    height = place.height
    is_relative = not height.is_amsl
    frames = (dialect.MAV_FRAME_GLOBAL, dialect.MAV_FRAME_GLOBAL_RELATIVE_ALT)
    return {
        "type": "SimpleItem",
        "autoContinue": True,
        "command": command,
        "frame": frames[is_relative],
        "params": [visit.hold_s, 0, 0, None, *place.position, height.metres],
        "Altitude": height.metres,
        "AltitudeMode": RELATIVE if is_relative else AMSL,
        "AMSLAltAboveTerrain": None,
    }


def _do(command: int, *params: float) -> dict[str, Any]:
    """An item without a position."""
    return {
        "type": "SimpleItem",
        "autoContinue": True,
        "command": command,
        "frame": dialect.MAV_FRAME_MISSION,
        "params": [*params, *[0] * (7 - len(params))],
    }
