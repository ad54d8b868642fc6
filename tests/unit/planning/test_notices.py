"""What a mission may say, and its author hardly meant."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest
from meadow import DATA
from synthetic import command, event, mission, planner

from companion.mission.literals import parse_effect
from companion.mission.loader import load_mission
from companion.mission.model import Mission
from companion.planning.notices import notices


def told(asked: Mission) -> list[str]:
    made = planner(asked)
    return [str(notice) for notice in notices(made, made.plan())]


def test_an_event_that_nothing_uses_is_noticed() -> None:
    asked = mission("F at(A)", events=[event("found"), event("low")])
    unused = "nothing uses this event: no line of the task, no skill"
    assert told(asked) == [f"found: {unused}", f"low: {unused}"]


def test_events_that_are_used_are_not() -> None:
    used = [
        event("asked"),
        event("low"),
        event("late"),
        event("anew", restarts=["task"]),
    ]
    plain, conditional = parse_effect("free & (late -> done)")
    careful = replace(command("do", "!low"), effect=plain, conditional=conditional)
    asked = mission("G (asked -> F at(A)) & F at(B)", skills=[careful], events=used)
    assert told(asked) == []


@pytest.mark.parametrize(("north_m", "notices_told"), [(0.5, 0), (3.0, 1)])
def test_a_mission_in_metres_that_begins_elsewhere_is_noticed(
    north_m: float, notices_told: int
) -> None:
    """Where it begins is where its metres count from: the vehicle stands there."""
    places = DATA["places"] | {"Home": DATA["places"]["Home"] | {"north_m": north_m}}
    limits = {"speed_mps": 4, "up_m": [1, 10], "fence": [[-9, -9], [30, -9], [30, 9], [-9, 9]]}
    text = (
        "Home: the mission begins there, 3.0 m from [0, 0], which is the autopilot's home position,"
        " where the vehicle stands at first, and from there no flight begins; write 3 m less for"
        " all that is north, its map included"
    )
    asked = load_mission(DATA | {"places": places, "limits": limits})
    assert told(asked) == [text] * notices_told


@pytest.mark.parametrize(
    ("task", "skill", "is_noticed"),
    [
        pytest.param("F[<=90s] seen", {}, True, id="nobody says how long it takes"),
        pytest.param("F[<=90s] seen", {"cost": 8}, False, id="the mission says it"),
        pytest.param("F[<=90s] seen", {"execute": "wait(20)"}, False, id="it only waits"),
        pytest.param("F[<=90s] at(A)", {"planned": False}, False, id="no plan has it"),
        pytest.param("F seen", {}, False, id="without a bound"),
    ],
)
def test_a_bound_that_covers_skills_without_cost_is_noticed(
    task: str, skill: dict[str, Any], is_noticed: bool
) -> None:
    execute = ["wait(20)", "command(payload, MAV_CMD_USER_1)"]
    look = {"precondition": "at(A)", "effect": "seen", "execute": execute} | skill
    limits = {"speed_mps": 4, "up_m": [1, 10], "fence": [[-9, -9], [30, -9], [30, 9], [-9, 9]]}
    skills = DATA["skills"] | {"look": look}
    keys = {
        "limits": limits,
        "skills": skills,
        "task": {"soon": task},
        "components": {"payload": 25},
    }
    text = (
        "look: without cost, so plans assume 21 s for it, and the bounds in time of soon hold"
        " only if it is done by then; write its time"
    )
    assert told(load_mission(DATA | keys)) == [text] * is_noticed


def on_earth(pond_up_m: float, **keys: Any) -> Mission:
    """A mission in degrees to a pond that is so high; all else is high enough."""
    places = {
        "Home": {"lat_deg": 47.397742, "lon_deg": 8.545594, "up_m": 6, "radius_m": 2},
        "Pond": {"lat_deg": 47.397560, "lon_deg": 8.546350, "up_m": pond_up_m},
        "Mark": {"lat_deg": 47.397560, "lon_deg": 8.545950, "up_m": 0.6},
    }
    fence = [[47.3973, 8.5449], [47.3973, 8.5469], [47.3986, 8.5469], [47.3986, 8.5449]]
    limits = {"speed_mps": 5, "up_m": [0.5, 40], "fence": fence}
    about = {
        "frame": "wgs84",
        "limits": limits,
        "places": places,
        "sets": {"Place": ["Home", "Pond"]},
    }
    return load_mission(DATA | about | {"task": {"visit": "F at(Pond)"}} | keys)


LOW = (
    "flown to so low above what is below, and the height of a vehicle with GPS may be off by 1.4 m;"
    " write 1.5 m or more"
)


@pytest.mark.parametrize(("up_m", "is_low"), [(0.6, True), (1.45, True), (1.5, False), (20, False)])
def test_a_place_lower_than_a_height_by_gps_is_certain_is_noticed(
    up_m: float, is_low: bool
) -> None:
    """A mark that nobody flies to may lie on the ground."""
    assert told(on_earth(up_m)) == [f"Pond ({up_m:g} m): {LOW}"] * is_low


def test_low_places_are_one_notice() -> None:
    asked = on_earth(1.2, sets={"Place": ["Home", "Pond", "Mark"]})
    assert told(asked) == [f"Pond (1.2 m), Mark (0.6 m): {LOW}"]


def test_a_height_counts_from_the_wall_below() -> None:
    """Drawn in metres about Home: the pond is 57 m east and 20 m south of it."""
    roof = {"walls": [{"east_m": [54, 60], "north_m": [-23, -17], "up_m": 3}]}
    assert f"Pond (1.2 m): {LOW}" in told(on_earth(4.2, map=roof))
    assert not any(LOW in text for text in told(on_earth(4.5, map=roof)))


def test_heights_of_a_mission_in_metres_are_taken_for_exact() -> None:
    """Nobody knows before the flight how good its position will be."""
    places = DATA["places"] | {"A": DATA["places"]["A"] | {"up_m": 1.2}}
    limits = {"speed_mps": 4, "up_m": [1, 10], "fence": [[-9, -9], [30, -9], [30, 9], [-9, 9]]}
    assert told(load_mission(DATA | {"places": places, "limits": limits})) == []


@pytest.mark.parametrize(
    ("line", "why"),
    [
        ("G(at(A) | !at(A))", ""),
        ("G(lost -> F at(A))", ", for lost never holds"),
        ("F at(H)", ""),
    ],
)
def test_a_line_that_holds_whatever_is_done_is_noticed(line: str, why: str) -> None:
    text = f"it: {line} holds from the start on, whatever is done{why}"
    assert told(mission({"it": line, "go": "F at(B)"})) == [text]


@pytest.mark.parametrize(
    "line",
    [
        "G (found -> F at(A))",
        "G (can_do -> F at(A))",
        "G (done -> F at(A))",
        "G !(at(A) & found)",
        "F at(B)",
    ],
)
def test_a_line_that_something_may_break_is_not(line: str) -> None:
    """Events and beliefs may change; what a skill makes needs them perhaps."""
    found = event("found")
    skills = [command("do", "found", "done")]
    asked = mission({"it": line, "see": "G (found -> F at(B))"}, skills=skills, events=[found])
    assert told(asked) == []


def test_what_is_met_at_the_start_and_begins_anew_is_not() -> None:
    again = event("again", restarts=["it"])
    assert told(mission({"it": "F at(H)", "go": "F at(B)"}, events=[again])) == []


def test_a_recurrence_that_a_rest_fulfils_is_noticed() -> None:
    (text,) = told(mission({"visit": "G F at(A)"}))
    assert text == (
        "visit: G F at(A) is met by resting for ever: the vehicle lands, and the flight ends"
    )
    assert told(mission({"visit": "G F at(A) & G F at(B)"})) == []


@pytest.mark.parametrize(("wall_m", "is_told"), [((19.0, 21.0), True), ((9.0, 11.0), False)])
def test_a_plan_that_ends_above_a_low_wall_is_noticed(
    wall_m: tuple[float, float], is_told: bool
) -> None:
    wall = {"east_m": [*wall_m], "north_m": [-1, 1], "up_m": 2}
    limits = {"speed_mps": 2, "up_m": [1, 6], "fence": [[-5, -5], [30, -5], [30, 5], [-5, 5]]}
    given = DATA | {"limits": limits, "map": {"walls": [wall]}, "task": {"go": "F at(A)"}}
    text = "A: the plan ends there, and lands above a wall of 2 m"
    assert told(load_mission(given)) == ([text] if is_told else [])


@pytest.mark.parametrize(("assumes", "notices_told"), [({}, 1), ({"assumes": "works"}, 0)])
def test_beliefs_that_would_be_held_again_and_are_none_are_noticed(
    assumes: dict[str, str], notices_told: int
) -> None:
    knock = {"effect": "done", "cost": 1, "execute": "wait(1)", "retry_after_s": 30} | assumes
    limits = {"speed_mps": 4, "up_m": [1, 10], "fence": [[-9, -9], [30, -9], [30, 9], [-9, 9]]}
    data = {"limits": limits, "task": {"knock": "F done"}}
    asked = load_mission(DATA | data | {"skills": DATA["skills"] | {"knock": knock}})
    text = "knock: retry_after_s has no effect: the skill assumes nothing (assumes)"
    assert told(asked) == [text] * notices_told
