"""Bounds in time on a battery: flights take more than the mission says, docks give less."""

from __future__ import annotations

from typing import Any

import pytest
from lockstep import Lockstep
from test_energy_factor import says
from two_docks import PADS, RESERVE, between_docks, lowest, text, two_docks

from companion.acting.behaviour_tree import landing
from companion.flight_events.energy import EnergyUsed
from companion.flight_events.facts import BeliefWithdrawn
from companion.flight_events.plans import NoPlanFound, PlanReplaced
from companion.flight_events.skills import PlaceReached, SkillCompleted
from companion.flight_events.sortie import ChargeCutShort, VehicleLanded
from companion.flight_events.word import ConjunctViolated
from companion.flights.simulated_world import world_of
from companion.mavlink.framing import dialect
from companion.mission.loader import load_mission

ALARM_EVERY_S = 80
"""Longer than it takes to charge again."""


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
    "power_w": says(0.8),
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


def ready(limit_s: float, current_a: float, **keys: Any) -> Lockstep:
    """A patrol that answers an alarm at A, whenever it comes."""
    task = {"patrol": "patrolling(A, B)", "answer": f"G (alarm -> F[<={limit_s}s] at(A))"}
    data = two_docks(task=task, ready=["answer"], **keys)
    data["events"] = {"alarm": {"when": "COMMAND.MAV_CMD_USER_1"}}
    percent_per_s = 0.003 * current_a
    data["skills"]["recharge"]["charge_rate"] = [[0, percent_per_s], [100, 0.1 * percent_per_s]]
    mission = load_mission(data)
    pads = [{**pad, "current_a": current_a} for pad in PADS]
    world = world_of(mission, between_docks(charge=0.27, pads=pads))
    return Lockstep(mission, world, seed=1, has_station=True)


def alarm(flight: Lockstep) -> float:
    """When it came."""
    flight.station_commands(dialect.MAV_CMD_USER_1, component=191)
    return flight.now_s


def answered_s(flight: Lockstep, since_s: float) -> float:
    """How long the answer took."""
    flight.run(30.0)
    reached = [(s.time_s, s.event) for s in flight.reports if isinstance(s.event, PlaceReached)]
    return min(t for t, event in reached if event.place == "A" and t > since_s) - since_s


@pytest.mark.long
def test_an_alarm_ends_a_charge_and_is_answered_in_time() -> None:
    flight = ready(26, current_a=4).until_reported(VehicleLanded)
    flight.run(30.0)
    assert answered_s(flight, alarm(flight)) < 20.0, text(flight)
    assert len(flight.of(ChargeCutShort)) == 1
    flight.until_reported(PlaceReached, limit_s=400.0, place="B")  # the lap goes on
    assert not violated(flight) and not flight.of(NoPlanFound), text(flight)


@pytest.mark.long
def test_alarms_at_any_time_are_answered_in_time_with_the_reserve() -> None:
    flight = ready(26, current_a=12)
    flight.run(20.0)
    for number in range(8):
        assert answered_s(flight, alarm(flight)) < 26.0, text(flight)
        assert lowest(flight, ALARM_EVERY_S - 30 + 7 * number % 20) >= RESERVE
    assert flight.of(ChargeCutShort) and not violated(flight), text(flight)
    assert not flight.of(NoPlanFound)
