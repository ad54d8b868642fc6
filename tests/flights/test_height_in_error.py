"""Flights whose altitude is off by a metre and more: by a range finder they stay off the ground."""

from __future__ import annotations

import pytest
from lockstep import Lockstep
from shipped import MISSIONS

from companion.acting.ground_guard import GroundGuard
from companion.flight_events.skills import GroundNear, SkillFailed
from companion.flight_events.sortie import TaskSatisfied, VehicleCrashed
from companion.mission.loader import load_mission
from companion.vehicle.ports.state import Mode
from sitl.world.scenario import read_scenario

WANDER = "airframe: px4_sih\nwander: {height_m: 1.0}\n"
FAR_OFF = 0  # a seed with which the altitude is off by 2 m


def lowest_m(flight: Lockstep) -> float:
    """How low the vehicle truly is in OFFBOARD, over the whole flight."""
    lowest = 9.0
    while not flight.companion.has_ended:
        flight.tick()
        state = flight.companion.telemetry.state
        if state is not None and state.heartbeat.mode is Mode.OFFBOARD and state.heartbeat.is_armed:
            lowest = min(lowest, -flight.simulation.flight.position[2])
    return lowest


def flight(seed: int, differs: str = WANDER) -> Lockstep:
    text = (MISSIONS / "surveillance.sim.yaml").read_text(encoding="utf-8")
    text = text.replace("map: maps/", f"map: {MISSIONS}/maps/") + differs
    mission = load_mission(MISSIONS / "surveillance.yaml")
    return Lockstep(mission, read_scenario(text), seed=seed)


@pytest.mark.parametrize(
    "seed", [FAR_OFF, *(pytest.param(seed, marks=pytest.mark.long) for seed in range(1, 12))]
)
def test_it_stays_off_the_ground_and_does_its_task(seed: int) -> None:
    flown = flight(seed)
    assert lowest_m(flown) >= 0.3
    assert flown.of(TaskSatisfied) and not flown.of(VehicleCrashed)
    assert flown.of(GroundNear) or seed != FAR_OFF


@pytest.mark.long
def test_an_altitude_that_stays_off_by_what_the_band_leaves_stops_no_task() -> None:
    """1.7 m off from the first leg on: the places at 2 m are visited 1.1 m above the ground."""
    flown = flight(1, "happens:\n  - {at_s: 12.0, estimate: {up_m: 1.7}}\n")
    assert 0.5 <= lowest_m(flown) < 1.2
    assert flown.of(TaskSatisfied)
    assert not [event for event in flown.of(SkillFailed) if event.action.startswith("move(")]
    assert len(flown.of(GroundNear)) == 1


@pytest.mark.long
def test_without_a_range_finder_it_does_not(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(GroundGuard, "kept_off", lambda _, told, *__: (told, None))
    flown = flight(FAR_OFF)
    assert lowest_m(flown) < 0.1
    assert not flown.of(TaskSatisfied)
