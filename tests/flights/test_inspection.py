"""Inspection among what the map does not show: another view point, and a site that is given up."""

from __future__ import annotations

from pathlib import Path

import pytest
from lockstep import Lockstep

from companion.flight_events.facts import BeliefWithdrawn
from companion.flight_events.skills import PlaceReached, SkillCompleted, SymbolMoved
from companion.geometry import horizontal_distance
from companion.mission.loader import load_mission
from sitl.world.scenario import read_scenario

MISSIONS = Path(__file__).parents[2] / "missions"
SEEDS = [1, *(pytest.param(seed, marks=pytest.mark.long) for seed in range(2, 11))]


@pytest.mark.parametrize("seed", SEEDS)
def test_a_blocked_site_is_seen_from_elsewhere_and_a_closed_one_is_given_up(seed: int) -> None:
    mission = load_mission(MISSIONS / "inspection.yaml")
    world = read_scenario(MISSIONS / "inspection.sim.yaml")
    flight = Lockstep(mission, world, seed=seed).until_the_end()
    assert flight.exit_code == 0
    assert flight.simulation.collisions == 0
    done = (SkillCompleted, BeliefWithdrawn, PlaceReached)
    assert [event for event in flight.events if isinstance(event, done)] == [
        SkillCompleted("inspect(Home, A)"),
        BeliefWithdrawn("accessible(B)"),
        SkillCompleted("inspect(here, C)"),
        PlaceReached("Home", "move(C, Home)"),
    ]
    view = flight.of(SymbolMoved, place="A")[-1]
    assert view.source == "samples of the region"
    site = mission.places["A"]
    assert horizontal_distance(view.position, site.position) <= site.inner_m
