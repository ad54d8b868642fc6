"""A battery that is low between walls, and a mission that says nothing of it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
from lockstep import Lockstep, World

from companion.acting.sortie.low_battery import IN_FLIGHT, LOW_S
from companion.flight_events.sortie import BatteryLow, Phase, PhaseEntered, RunFailed
from companion.mission.loader import load_mission
from companion.mission.model import Mission
from sitl.world.battery_schema import BatteryEventModel
from sitl.world.scenario import read_scenario
from sitl.world.scenario_events import ScenarioEvent, TimeTrigger

MISSIONS = Path(__file__).parents[2] / "missions"


def low_soon(world: World, charge: float = 0.165) -> World:
    scenario, grid = world
    return replace(scenario, battery=replace(scenario.battery, charge=charge)), grid


def is_home(flight: Lockstep) -> bool:
    north_m, east_m, _ = flight.simulation.flight.position
    return not flight.simulation.is_armed and abs(north_m) < 0.5 and abs(east_m) < 0.5


def test_it_flies_home_by_its_own_routes(surveillance: Mission, short_hall: World) -> None:
    flight = Lockstep(surveillance, low_soon(short_hall))
    flight.until_the_end()
    assert flight.ending == RunFailed(IN_FLIGHT, 5)
    assert flight.places  # it was under way
    assert flight.time_of(BatteryLow) >= LOW_S
    assert is_home(flight) and flight.simulation.collisions == 0


@pytest.mark.long
@pytest.mark.parametrize("charge", [0.152, 0.156, 0.16, 0.164, 0.168, 0.172])
@pytest.mark.parametrize("name", ["surveillance", "delivery", "corridor", "inspection"])
def test_wherever_it_is_then_it_comes_home(name: str, charge: float) -> None:
    world = read_scenario(MISSIONS / f"{name}.sim.yaml")
    flight = Lockstep(load_mission(MISSIONS / f"{name}.yaml"), low_soon(world, charge))
    flight.until_the_end()
    assert flight.ending == RunFailed(IN_FLIGHT, 5) or not flight.of(BatteryLow)
    assert is_home(flight) and flight.simulation.collisions == 0


@pytest.mark.long
def test_killed_on_that_way_home_it_ends_as_it_would_have(
    surveillance: Mission, short_hall: World
) -> None:
    flight = Lockstep(surveillance, low_soon(short_hall), has_station=True, resumes=True)
    flight.until_reported(PhaseEntered, phase=Phase.RETURNING).run(1.0)
    flight.kill()
    flight.run(3.0)
    flight.restart()
    flight.until_the_end()
    assert flight.ending == RunFailed(IN_FLIGHT, 5) and is_home(flight)


def test_a_battery_that_drops_at_once(surveillance: Mission, short_hall: World) -> None:
    scenario, grid = short_hall
    drops = ScenarioEvent(
        TimeTrigger(20.0), (("battery", BatteryEventModel(charge=0.12)),), "it drops"
    )
    flight = Lockstep(surveillance, (replace(scenario, events=(*scenario.events, drops)), grid))
    flight.until_the_end()
    assert 20.0 + LOW_S < flight.time_of(BatteryLow) < 20.0 + LOW_S + 3.0
    assert flight.ending == RunFailed(IN_FLIGHT, 5) and is_home(flight)
    assert flight.simulation.collisions == 0
