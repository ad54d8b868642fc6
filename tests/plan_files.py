"""Small files of ground stations and mapping tools, made of what a test is about."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from companion.geometry import GlobalOrigin
from companion.plans.draft import Draft
from companion.plans.draft_places import Given
from companion.plans.files import import_plan

HOME = (47.397742, 8.545594)
HOME_AMSL_M = 488.0
NOTHING = Given()


def at(north_m: float, east_m: float) -> tuple[float, float]:
    """A point about home, in degrees."""
    return GlobalOrigin(*HOME, 0.0).to_global((north_m, east_m, 0.0))[:2]


def square(reach_m: float, north_m: float = 0.0) -> list[list[float]]:
    """The corners of a square about home, or about a point north of it."""
    signs = ((-1, -1), (-1, 1), (1, 1), (1, -1))
    return [list(at(north_m + n * reach_m, e * reach_m)) for n, e in signs]


def item(command: int, *params: float | None, frame: int = 3, **more: Any) -> dict[str, Any]:
    """An item of a .plan; params that are not given are 0."""
    seven = [*params, *[0.0] * (7 - len(params))]
    return {"type": "SimpleItem", "command": command, "frame": frame, "params": seven} | more


def waypoint(
    north_m: float, east_m: float, up_m: float = 20.0, hold_s: float = 0.0, **more: Any
) -> dict[str, Any]:
    """A waypoint about home."""
    return item(16, hold_s, 0, 0, None, *at(north_m, east_m), up_m, **more)


TAKE_OFF = item(22, 0, 0, 0, None, 0, 0, 20)
RETURN = item(20, frame=2)


def plan(*items: dict[str, Any], **more: Any) -> dict[str, Any]:
    """A .plan with these items; `polygons`, `circles` and `rally` go where they belong."""
    numbered = [{"doJumpId": i, "autoContinue": True} | each for i, each in enumerate(items, 1)]
    fence = {key: more.pop(key, []) for key in ("polygons", "circles")}
    points = more.pop("rally", [])
    return {
        "fileType": "Plan",
        "version": 1,
        "groundStation": "QGroundControl",
        "mission": {
            "version": 2,
            "firmwareType": 12,
            "vehicleType": 2,
            "plannedHomePosition": [*HOME, HOME_AMSL_M],
            "items": numbered,
        }
        | more,
        "geoFence": {"version": 2} | fence,
        "rallyPoints": {"version": 2, "points": points},
    }


def polygon(corners: Sequence[Sequence[float]], inclusion: bool = True) -> dict[str, Any]:
    """A polygon of a fence."""
    return {"polygon": [list(c) for c in corners], "inclusion": inclusion, "version": 1}


def circle(centre: Sequence[float], radius_m: float, inclusion: bool = True) -> dict[str, Any]:
    """A circle of a fence."""
    about = {"center": list(centre), "radius": radius_m}
    return {"circle": about, "inclusion": inclusion, "version": 1}


def imported(
    folder: Path, content: Any, name: str = "field.plan", given: Given = NOTHING, *leave_out: str
) -> tuple[str, Draft]:
    """The mission of a file with this content: bytes, a text, or data for JSON."""
    path = folder / name
    if isinstance(content, bytes):
        path.write_bytes(content)
    else:
        text = content if isinstance(content, str) else json.dumps(content)
        path.write_text(text, encoding="utf-8")
    return import_plan(path, given, frozenset(leave_out), "")
