"""Bounds in time on a battery: flights take more than the mission says, docks give less."""

from __future__ import annotations

from typing import Any

import pytest
from lockstep import Lockstep
from test_energy_factor import POWER_W
from two_docks import PADS, RESERVE, between_docks, lowest, text, two_docks

from companion.acting.behaviour_tree import landing
from companion.api.simulating import world_of
from companion.flight_events.energy import EnergyUsed
from companion.flight_events.facts import BeliefWithdrawn
from companion.flight_events.plans import NoPlanFound, PlanReplaced
from companion.flight_events.skills import SkillCompleted
from companion.flight_events.word import ConjunctViolated
from companion.mission.loader import load_mission


def fly(often_s: float, pads: list[dict[str, Any]] = PADS, **keys: Any) -> Lockstep:
    task = {"patrol": "patrolling(A, B)", "often": f"revisit(A) <= {often_s} s"}
    mission = load_mission(two_docks(task=task, **keys))
    return Lockstep(mission, world_of(mission, between_docks(pads=pads)), seed=1)


def violated(flight: Lockstep) -> list[str]:
    told = (stamped.event for stamped in flight.recorded)
    return [event.conjunct for event in told if isinstance(event, ConjunctViolated)]


THIRSTY = {
    "reserve": RESERVE,
    "capacity_wh": 75.5,
    "power_w": POWER_W,
    "curve": [[0, 0], [20, 18.7], [60, 58], [80, 78.6], [90, 89.2], [100, 100]],
}
"""A battery whose flights take a quarter more than that."""


@pytest.mark.long
def test_a_bound_is_kept_while_plans_learn_that_flights_take_more() -> None:
    flight = fly(90, battery=THIRSTY)
    assert lowest(flight, 250.0) >= RESERVE - 0.3
    assert flight.of(EnergyUsed)[-1].factor > 1.15 and flight.of(PlanReplaced), text(flight)
    assert not violated(flight) and not flight.of(NoPlanFound), text(flight)


@pytest.fixture
def soon_given_up(monkeypatch: pytest.MonkeyPatch) -> None:
    """A dock that does not charge, or too slowly, is left after half a minute, not two or four."""
    monkeypatch.setattr(landing, "NO_CHARGE_S", 30.0)
    monkeypatch.setattr(landing, "SLOW_WINDOWS", 1)


@pytest.mark.long
@pytest.mark.usefixtures("soon_given_up")
def test_a_slow_dock_is_left_and_the_bound_is_kept_by_the_other() -> None:
    flight = fly(150, [PADS[0], {**PADS[1], "current_a": 10}])
    flight.until_reported(BeliefWithdrawn, limit_s=300.0)
    flight.until_reported(SkillCompleted, limit_s=200.0, action="recharge(W)")
    assert lowest(flight, 60.0) >= RESERVE
    assert not violated(flight) and not flight.of(NoPlanFound), text(flight)


@pytest.mark.long
@pytest.mark.usefixtures("soon_given_up")
def test_docks_too_slow_for_the_bound_end_the_task() -> None:
    """The violation is told when the bound passes, and the vehicle lands with the reserve.

    With bounds the search on a battery is given up at a limit, which is no proof: exit code 7.
    """
    flight = fly(60, [{**pad, "current_a": 10} for pad in PADS])
    least = lowest(flight, 400.0)
    assert violated(flight) == ["often"] and flight.exit_code in (3, 7), text(flight)
    assert least >= RESERVE and not flight.simulation.is_armed
