"""What leaves a vehicle no chance is no failure."""

from __future__ import annotations

from dataclasses import replace

from varied import short_kit

from companion.campaigns.fairness import unfair
from companion.campaigns.rows import Value
from companion.flights.simulated_world import varied_world_of
from sitl.world.obstacles import Obstacle


def at_a_place(away_m: float) -> tuple[Obstacle, ...]:
    north, east, _ = next(iter(short_kit().mission.places.values())).position
    centre = (north + away_m, east)
    return (Obstacle("crate", centre, centre, 0.5, True),)


def test_an_obstacle_that_was_moved_onto_a_place_is_unfair() -> None:
    kit = short_kit()
    scenario, _ = kit.scenario.world({})
    for away_m, is_unfair in ((0.0, True), (1.3, True), (1.4, False)):
        moved = replace(scenario, obstacles=at_a_place(away_m))
        assert bool(unfair(kit.mission, moved, {"crate"})) == is_unfair


def test_an_obstacle_that_no_factor_moves_stands_where_it_was_meant_to() -> None:
    kit = short_kit()
    scenario, _ = kit.scenario.world({})
    moved = replace(scenario, obstacles=at_a_place(0.0))
    assert unfair(kit.mission, moved, set()) == ""


def reason_of(world: dict[str, object], values: dict[str, Value]) -> str:
    mission = short_kit().mission
    north, east, _ = [*mission.places.values()][-1].position
    crate = {"name": "crate", "circle": {"east_m": east, "north_m": north, "radius_m": 0.5}}
    shed = {"name": "shed", "circle": {"east_m": 90, "north_m": 90, "radius_m": 0.5}}
    varied = varied_world_of(mission, {"version": 1, "obstacles": [shed, crate], **world})
    return unfair(mission, varied.world(values)[0], varied.moved_obstacles(values))


def test_an_obstacle_that_is_only_there_or_not_is_moved_by_nothing() -> None:
    for path in ("obstacles.crate", "obstacles.1", "obstacles.crate.present"):
        assert reason_of({"vary": {path: {"chance": 0.5}}}, {path: True}) == ""


def test_an_obstacle_is_known_by_its_number_where_one_before_it_is_left_out() -> None:
    vary = {"obstacles.0": {"chance": 0.5}, "obstacles.1.circle.radius_m": [0.3, 0.6]}
    for is_there in (True, False):
        values: dict[str, Value] = {"obstacles.0": is_there, "obstacles.1.circle.radius_m": 0.5}
        assert "the obstacle crate on " in reason_of({"vary": vary}, values)


def test_an_obstacle_that_is_never_there_is_fair() -> None:
    radius = "obstacles.crate.circle.radius_m"
    appears = {"at_s": 1, "obstacle": {"name": "crate", "present": True}}
    vary = {
        radius: [0.3, 0.6],
        "obstacles.crate.present": {"chance": 0.5},
        "happens.0": {"chance": 0.5},
    }
    world: dict[str, object] = {"happens": [appears], "vary": vary}
    for present, event in ((False, False), (False, True), (True, False)):
        values: dict[str, Value] = {
            radius: 0.5, "obstacles.crate.present": present, "happens.0": event
        }  # fmt: skip
        assert bool(reason_of(world, values)) == (present or event)
