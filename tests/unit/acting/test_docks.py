"""Which other docks count while the vehicle stands on one that gives nothing."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

import pytest
from two_docks import two_docks

from companion.acting.docks import PlannedDock
from companion.mission.loader import load_mission
from companion.planning.planner import Planner
from companion.planning.task_state import TaskState

FLIES_THERE = {
    "parameters": {"from": "Place", "pad": "Pad"},
    "precondition": "at(from)",
    "effect": "at(pad) & !at(from)",
    "execute": ["fly(pad)", "land()", "charge(auto)", "take_off()"],
}
"""Fields of a skill that flies to the dock itself: it exists from each place to each dock."""
RESERVE, LEFT, PATIENCE_S = 5, 10, 600.0


def on_dock_e(out_of_reach: str, fields: dict[str, Any]) -> PlannedDock:
    """It has come there from A, and the charge lasts for all places but one."""
    given = two_docks(patience_s=PATIENCE_S)
    given["skills"]["recharge"] |= fields
    real = Planner(load_mission(given))
    task = TaskState(real)
    task.running = next(
        action
        for action in real.actions.model.actions
        if action.skill == "recharge" and action.arguments in (("E",), ("A", "E"))
    )
    energy = SimpleNamespace(
        model=SimpleNamespace(reserve=RESERVE),
        charge=SimpleNamespace(least=lambda: LEFT),
        to_land_at=lambda place: None if place == out_of_reach else 0,
    )
    planner = SimpleNamespace(actions=real.actions, mission=real.mission, energy=energy)
    return PlannedDock(cast(Planner, planner), task)


@pytest.mark.parametrize("fields", [{}, FLIES_THERE])
@pytest.mark.parametrize(("out_of_reach", "patience_s"), [("W", PATIENCE_S), ("A", 0.0)])
def test_only_another_dock_that_the_charge_lasts_for_ends_the_wait(
    out_of_reach: str, patience_s: float, fields: dict[str, Any]
) -> None:
    assert on_dock_e(out_of_reach, fields).patience_s == patience_s
