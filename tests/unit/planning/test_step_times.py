"""What skills cost of which nobody has said it: their flights on the map, their waits, a second."""

from __future__ import annotations

from typing import Any

import pytest
from meadow import DATA

from companion.mission.loader import load_mission
from companion.planning.domain import UNIT_MS, Action
from companion.planning.planner import Planner

LIMITS = {"speed_mps": 4, "up_m": [1, 10], "fence": [[-9, -9], [30, -9], [30, 9], [-9, 9]]}
COMMAND = "command(payload, MAV_CMD_USER_1)"


def actions(execute: Any, **more: Any) -> dict[str, Action]:
    """Those of a mission with one more skill, which goes where `move` does."""
    asked = {key: DATA["skills"]["move"][key] for key in ("parameters", "precondition", "effect")}
    skills = DATA["skills"] | {"asked": asked | {"execute": execute}}
    about = {"skills": skills, "limits": LIMITS, "components": {"payload": 25}} | more
    planner = Planner(load_mission(DATA | about))
    return {action.name: action for action in planner.actions.model.actions}


@pytest.mark.parametrize(
    ("execute", "waits_s"),
    [
        (["fly(to)"], 0.0),
        (["fly(to)", "wait(10)"], 10.0),
        (["wait(1)", "fly(to)", COMMAND, "wait(2.5)"], 3.5),
        (["move(from, to)", "wait(5)"], 5.0),
    ],
)
def test_a_skill_that_flies_takes_its_flight_and_its_waits(
    execute: list[str], waits_s: float
) -> None:
    found = actions(execute)
    flight_ms = found["move(Home, A)"].cost_ms
    assert flight_ms > 4000
    assert abs(found["asked(Home, A)"].cost_ms - flight_ms - 1000 * waits_s) <= UNIT_MS


@pytest.mark.parametrize(
    ("execute", "cost_s"),
    [
        (COMMAND, 1.0),
        ("wait(2.5)", 2.5),
        ([COMMAND, "wait(2.5)", COMMAND, "wait(4)"], 7.5),
        ("wait(0)", 1.0),
    ],
)
def test_a_skill_on_the_spot_takes_its_waits_and_a_second_for_all_else(
    execute: str | list[str], cost_s: float
) -> None:
    skill = {"precondition": "at(A)", "effect": "done", "execute": execute}
    skills = {"skills": DATA["skills"] | {"asked": skill}}
    about = {"limits": LIMITS, "components": {"payload": 25}, "task": {"t": "F done"}}
    planner = Planner(load_mission(DATA | about | skills))
    (action,) = (action for action in planner.actions.model.actions if action.skill == "asked")
    assert action.cost_ms == 1000 * cost_s


def test_what_waits_after_its_flight_hovers_so_long() -> None:
    battery = {"reserve": 20}
    found = actions(["fly(to)", "wait(60)"], battery=battery)
    short = actions(["fly(to)"], battery=battery)
    more = found["asked(Home, A)"].drain - found["move(Home, A)"].drain
    assert more > 2 * found["move(Home, A)"].drain > 0
    assert short["asked(Home, A)"].drain == found["move(Home, A)"].drain
