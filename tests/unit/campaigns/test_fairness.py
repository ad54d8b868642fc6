"""What leaves a vehicle no chance is no failure."""

from __future__ import annotations

from dataclasses import replace

from varied import short_kit

from companion.campaigns.fairness import unfair
from sitl.world.obstacles import Obstacle

EAST = "obstacles.crate.circle.east_m"


def at_a_place(away_m: float) -> tuple[Obstacle, ...]:
    north, east, _ = next(iter(short_kit().mission.places.values())).position
    centre = (north + away_m, east)
    return (Obstacle("crate", centre, centre, 0.5, True),)


def test_an_obstacle_that_was_moved_onto_a_place_is_unfair() -> None:
    kit = short_kit()
    scenario, _ = kit.scenario.world({})
    for away_m, is_unfair in ((0.0, True), (1.3, True), (1.4, False)):
        moved = replace(scenario, obstacles=at_a_place(away_m))
        assert bool(unfair(kit.mission, moved, {EAST: 0.0})) == is_unfair


def test_an_obstacle_that_no_factor_moves_stands_where_it_was_meant_to() -> None:
    kit = short_kit()
    scenario, _ = kit.scenario.world({})
    moved = replace(scenario, obstacles=at_a_place(0.0))
    assert unfair(kit.mission, moved, {"wind.east_mps": 1.0}) == ""
