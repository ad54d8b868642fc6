"""Headings in mission files: `heading_deg` of a place, `look_at` of a skill, and their mistakes."""

from __future__ import annotations

import math
from typing import Any

import pytest
from moves import MOVE

from companion.errors import MissionError
from companion.mission.loader import load_mission
from companion.mission.places import PointOfInterest
from companion.planning.instances import instantiate


def data(photo: dict[str, Any] | None = None, **a: Any) -> dict[str, Any]:
    """A room with three places, two of them above each other."""
    skill = {"precondition": "at(A)", "effect": "taken", "execute": "wait(1)", **(photo or {})}
    return {
        "version": 1,
        "name": "photo",
        "map": {"east_m": [-5, 15], "north_m": [-5, 15]},
        "limits": {"speed_mps": 2, "up_m": [0.5, 5], "fence": [[-2, -2], [9, -2], [9, 9], [-2, 9]]},
        "places": {
            "Home": {"east_m": 0, "north_m": 0, "up_m": 2},
            "A": {"east_m": 5, "north_m": 0, "up_m": 2, **a},
            "Above": {"east_m": 5, "north_m": 0.2, "up_m": 4},
        },
        "objects": ["thing"],
        "sets": {"Place": ["Home", "A"], "Any": ["Home", "A", "Above"], "Thing": ["thing", "A"]},
        "skills": {"move": MOVE, "photo": skill},
        "initially": ["at(Home)"],
        "task": {"photo": "F taken"},
    }


@pytest.mark.parametrize(
    ("deg", "rad"), [(0, 0), (90, math.pi / 2), (270, -math.pi / 2), (-45, -math.pi / 4), (360, 0)]
)
def test_a_heading_is_clockwise_from_north(deg: float, rad: float) -> None:
    places = load_mission(data(heading_deg=deg)).places
    assert places["A"].heading_rad == pytest.approx(rad)
    assert places["Home"].heading_rad is None


def test_a_skill_looks_at_a_place_or_a_point() -> None:
    assert load_mission(data({"look_at": "Home"})).skills["photo"].look_at == PointOfInterest(
        "Home", (0.0, 0.0)
    )
    wall = {"east_m": 40, "north_m": -3}  # neither on the map nor within the fence
    look_at = load_mission(data({"look_at": wall})).skills["photo"].look_at
    assert look_at == PointOfInterest("east 40 m, north -3 m", (-3.0, 40.0))


def test_a_parameter_is_bound_in_each_action() -> None:
    mission = load_mission(
        data({"look_at": "q", "parameters": {"q": "Place"}, "distinct": [["q", "A"]]})
    )
    actions = instantiate(mission, lambda *_: 1.0).actions
    looks = {action.name: action.look_at for action in actions if action.skill == "photo"}
    assert looks == {"photo(Home)": PointOfInterest("Home", (0.0, 0.0))}


def test_a_flight_may_look_at_where_it_leads() -> None:
    """A place is a region; from where in it the vehicle looks is found in flight."""
    flight = {**MOVE, "look_at": "to", "effect": "at(to) & !at(from) & taken"}
    assert load_mission(data(flight)).skills["photo"].look_at == "to"


MISTAKES: list[tuple[dict[str, Any], str, str]] = [
    ({"look_at": "Hme"}, "looks at Hme, which is not a parameter or place", "Did you mean Home?"),
    (
        {"look_at": "q", "parameters": {"q": "Thing"}},
        "cannot look at thing, no place",
        "places are Home, A, Above",
    ),
    ({"look_at": "A"}, "looks at A from A: no direction", "distinct"),
    ({"look_at": "Above"}, "looks at Above from A: no direction", "0.5 m away"),
    (
        {"look_at": "q", "parameters": {"q": "Place"}},
        "looks at A from A: no direction",
        "distinct",
    ),
    (
        {"look_at": "p", "parameters": {"p": "Place"}, "precondition": "at(p)"},
        "looks at Home from Home: no direction",
        "",
    ),
    (
        {
            "look_at": "q",
            "parameters": {"p": "Any", "q": "Any"},
            "precondition": "at(p)",
            "distinct": [["p", "q"]],
        },
        "looks at Above from A: no direction",
        "",
    ),
    (
        {"look_at": "Home", "execute": ["land()", "take_off()"]},
        "does not fly, command or wait",
        "remove look_at",
    ),
    ({"look_at": {"east_m": 1}}, "north_m", ""),
    ({"look_at": None}, "has no value", ""),
]


@pytest.mark.parametrize(("photo", "what", "hint"), MISTAKES)
def test_what_cannot_be_looked_at_is_refused(photo: dict[str, Any], what: str, hint: str) -> None:
    with pytest.raises(MissionError) as error:
        load_mission(data(photo))
    assert what in str(error.value) and hint in str(error.value)
    assert "skills.photo" in str(error.value)


@pytest.mark.parametrize("deg", [361, -400, "north", None])
def test_a_heading_is_degrees(deg: object) -> None:
    with pytest.raises(MissionError, match=r"places\.A\.heading_deg"):
        load_mission(data(heading_deg=deg))
