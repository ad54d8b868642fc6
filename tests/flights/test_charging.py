"""A patrol that lands, charges and goes on, against the simulator's battery and pad."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
from lockstep import Lockstep

from companion.mission.loader import load_mission
from sitl.world.scenario import read_scenario

MISSIONS = Path(__file__).parents[2] / "missions"
CYCLES = 3


def fly(seed: int, **changes: object) -> Lockstep:
    scenario, grid = read_scenario(MISSIONS / "persistent_patrol.sim.yaml")
    scenario = replace(scenario, **changes)  # type: ignore[arg-type]
    mission = load_mission(MISSIONS / "persistent_patrol.yaml")
    flight = Lockstep(mission, (scenario, grid), seed=seed)
    return flight.until(lambda: flight.companion.has_ended, 600.0)


@pytest.mark.parametrize(
    "seed", [1, *(pytest.param(seed, marks=pytest.mark.long) for seed in range(2, 11))]
)
def test_it_charges_three_times_and_goes_on_where_it_was(seed: int) -> None:
    flight = fly(seed)
    assert flight.texts[-1] == "task satisfied, landed"
    assert flight.exit_code == 0
    assert flight.simulation.collisions == 0
    assert flight.texts.count("recharge(here, Dock) done") == CYCLES
    assert flight.armings == 1 + CYCLES
    places = [report.text[-1] for report in flight.reports if report.kind == "at"]
    sites = "".join(place for place in places if place in "ABC")
    assert sites == ("ABC" * 9)[: len(sites)]
    assert len(sites) >= 3 * CYCLES
    assert places[-1] == "e"  # Home


def test_a_dock_without_power_is_given_up_and_the_vehicle_goes_home() -> None:
    flight = fly(1, pads=())
    failed = "recharge(here, Dock) failed: the battery does not charge, it is at "
    at = next(i for i, text in enumerate(flight.texts) if text.startswith(failed))
    assert flight.texts[at + 1] == "belief canCharge(Dock) withdrawn"
    assert "no plan" in flight.texts[at + 2]
    assert flight.texts[-2:] == ["landing", flight.texts[-1]]
    assert "at Home" in flight.texts[at:]
    assert flight.exit_code == 3
    assert flight.armings == 2
