"""What no line of a task asks for is not done, however the automata read the lap."""

from __future__ import annotations

from typing import Any

import pytest
from moves import MOVE

from companion.mission.loader import load_mission
from companion.planning.planner import Planner

AT = {"Home": (0, 0), "A": (20, 0), "B": (20, 20), "C": (0, 20)}
MISSION: dict[str, Any] = {
    "version": 1,
    "name": "four",
    "limits": {"speed_mps": 4, "up_m": [1, 10], "fence": [[-9, -9], [29, -9], [29, 29], [-9, 29]]},
    "places": {name: {"east_m": e, "north_m": n, "up_m": 3} for name, (e, n) in AT.items()},
    "sets": {"Place": [*AT], "Site": ["A", "B"]},
    "components": {"payload": 25},
    "events": {
        "alarm": {"when": "COMMAND.MAV_CMD_USER_3", "latch": True},
        "personSeen": {"when": "COMMAND.MAV_CMD_USER_2"},
    },
    "skills": {"move": MOVE},
    "initially": ["at(Home)"],
}
DROP = {
    "parameters": {"s": "Site"},
    "precondition": "at(s)",
    "effect": "dropped(s)",
    "execute": "command(payload, MAV_CMD_USER_1)",
    "cost": 2,
}
FOR_EVER = [
    "G (alarm -> F (at(A) & F at(B)))",
    "G (alarm -> F (at(A) & X F at(B)))",
    "G (alarm -> F (at(A) & F (at(B) & F at(C))))",
    "G (alarm -> F at(A)) & G (alarm -> F (at(B) & F at(A)))",
    "G F (at(A) & F at(B))",
    "G (alarm -> (F at(A) & F at(B) & F at(C)))",
]


BOUNDED = ["F[<=60s] at(C)", "G (alarm -> F[<=60s] at(C))", "revisit(at(A)) <= 60 s"]


@pytest.mark.parametrize(
    ("for_ever", "bounded"),
    [
        pytest.param(for_ever, bounded, marks=[pytest.mark.long] if (i + j) % 3 else [])
        for i, for_ever in enumerate(FOR_EVER)
        for j, bounded in enumerate(BOUNDED)
    ],
)
def test_a_skill_that_nothing_asks_for_changes_no_plan(for_ever: str, bounded: str) -> None:
    """Laps as short are there before the drops and after them; the way in is shorter before."""
    task = {"for_ever": for_ever, "bounded": bounded}
    skills = MISSION["skills"] | {"drop": DROP}
    helping = task | {"help": "G (personSeen -> F dropped(A))"}
    with_drop = MISSION | {"skills": skills, "task": helping}
    plans = [
        Planner(load_mission(each)).plan(facts={"alarm"}).lasso
        for each in (MISSION | {"task": task}, with_drop)
    ]
    without, beside = ([sum(a.cost_ms for a in p) for p in (x.prefix, x.loop)] for x in plans)
    assert beside == without
    assert not [a.name for p in (plans[1].prefix, plans[1].loop) for a in p if a.skill == "drop"]
