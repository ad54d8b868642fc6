"""Markers of places, and where skills may land: what is read, and what is refused with words."""

from __future__ import annotations

from typing import Any

import pytest

from companion.errors import MissionError
from companion.mission.loader import load_mission
from companion.mission.markers import LandingMarker

ROOF = {"east_m": [2, 10], "north_m": [-4, 4], "up_m": 3}


def data(marker: Any = None, execute: Any = "land_on(p)", **changes: Any) -> dict[str, Any]:
    """A roof with a place above it, and a skill that lands there."""
    place = {"east_m": 6, "north_m": 0, "up_m": 6, "radius_m": 1.5} | changes.pop("place", {})
    about = {"marker": {"component": "camera"} if marker is None else marker} if marker != 0 else {}
    stand = {"parameters": {"p": "Pad"}, "precondition": "at(p)", "effect": "stood"}
    return {
        "version": 1,
        "name": "pad",
        "limits": {"speed_mps": 2, "up_m": [1, 8], "fence": [[-5, -8], [14, -8], [14, 8], [-5, 8]]},
        "map": {"walls": [ROOF, *changes.pop("walls", [])]},
        "components": {"camera": 40, "autopilot": 1},
        "places": {"Home": {"east_m": 0, "north_m": -6, "up_m": 2}, "P": {**place, **about}},
        "sets": {"Place": ["Home", "P"], "Pad": ["P"]},
        "skills": {"stand": {**stand, "execute": execute, **changes.pop("skill", {})}},
        "initially": ["at(Home)"],
        "task": {"stand": "F stood"},
    }


def test_a_marker_lies_as_high_as_what_is_drawn_below_its_place() -> None:
    assert load_mission(data()).places["P"].marker == LandingMarker(40, 0, 3.0)
    on_ground = data({"component": "camera", "number": 3}, place={"east_m": 0, "north_m": 5})
    assert load_mission(on_ground).places["P"].marker == LandingMarker(40, 3, 0.0)


MISTAKES: list[tuple[dict[str, Any], str]] = [
    (data({"component": "camra"}), "unknown component camra"),
    (data({"component": "autopilot"}), "autopilot is the autopilot, which sees no markers"),
    (data(place={"radius_m": 4}), "may lie within 0.6 m of the edge of a wall with up_m"),
    (data(place={"east_m": 8.5}), "may lie within 0.6 m of the edge of a wall with up_m"),
    (data(walls=[{"east_m": [7, 8], "north_m": [1, 2], "up_m": 4}]), "of the edge of a wall"),
    (data(place={"up_m": 3.8}), "lies 3 m high, and the place only 0.8 m above it"),
    (data(0), "stand lands on the marker of P, which has none"),
    (data(0, "land()"), "stand lands at P, above a wall of 3 m"),
    (data(skill={"precondition": "at(Home)"}), "lands on the marker of p, and is at Home"),
    (data(skill={"precondition": "lit", "assumes": "lit"}), "marker of p, and may be anywhere"),
    (data(execute="land_on(q)"), "q is not a parameter of this skill"),
    (data(execute="land_on()"), "land_on has 0 arguments"),
]


@pytest.mark.parametrize(
    ("mission", "what"), MISTAKES, ids=lambda x: x if isinstance(x, str) else ""
)
def test_a_landing_that_cannot_be_meant_is_refused(mission: dict[str, Any], what: str) -> None:
    with pytest.raises(MissionError) as refused:
        load_mission(mission)
    assert what in str(refused.value)
    assert refused.value.hint
