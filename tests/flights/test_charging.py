"""A patrol that lands, charges and goes on, against the simulator's battery and pad."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
from lockstep import Lockstep

from companion.acting.behaviour_tree import landing
from companion.flight_events.facts import BeliefWithdrawn
from companion.flight_events.plans import NoPlanFound
from companion.flight_events.skills import SkillCompleted, SkillFailed
from companion.flight_events.sortie import Phase, PhaseEntered, TaskSatisfied
from companion.mission.loader import load_mission
from sitl.world.scenario import read_scenario

MISSIONS = Path(__file__).parents[2] / "missions"
CYCLES = 3


def fly(seed: int, **changes: object) -> Lockstep:
    scenario, grid = read_scenario(MISSIONS / "persistent_patrol.sim.yaml")
    scenario = replace(scenario, **changes)  # type: ignore[arg-type]
    mission = load_mission(MISSIONS / "persistent_patrol.yaml")
    return Lockstep(mission, (scenario, grid), seed=seed)


def test_it_goes_on_after_a_charge_where_it_was() -> None:
    flight = fly(1).until_reported(SkillCompleted, 200.0, action="recharge(here, Dock)")
    before = [place for place in flight.places if place in ("A", "B", "C")]
    flight.until(lambda: len(flight.places) > len(before))
    sites = "".join(place for place in flight.places if place in ("A", "B", "C"))
    assert len(before) > 1 and sites == ("ABC" * 9)[: len(before) + 1]
    assert flight.armings == 2 and flight.simulation.collisions == 0


@pytest.mark.long
@pytest.mark.parametrize("seed", range(1, 11))
def test_it_charges_three_times_and_goes_on_where_it_was(seed: int) -> None:
    flight = fly(seed).until_the_end(600.0)
    assert flight.ending == TaskSatisfied()
    assert flight.simulation.collisions == 0
    assert len(flight.of(SkillCompleted, action="recharge(here, Dock)")) == CYCLES
    assert flight.armings == 1 + CYCLES
    sites = "".join(place for place in flight.places if place in ("A", "B", "C"))
    assert sites == ("ABC" * 9)[: len(sites)]
    assert len(sites) > 2 * CYCLES
    assert flight.places[-1] == "Home"


@pytest.mark.long
def test_a_dock_without_power_is_given_up_and_the_vehicle_goes_home(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(landing, "NO_CHARGE_S", 15.0)
    flight = fly(1, pads=()).until_the_end(600.0)
    failed = flight.one(SkillFailed, action="recharge(here, Dock)")
    assert failed.reason.startswith("the battery does not charge, it is at ")
    at = flight.events.index(failed)
    assert flight.events[at + 1] == BeliefWithdrawn("canCharge(Dock)")
    assert isinstance(flight.events[at + 2], NoPlanFound)
    assert flight.events[-2] == PhaseEntered(Phase.LANDING)
    assert flight.places[-1] == "Home"
    assert flight.exit_code == 3
    assert flight.armings == 2
