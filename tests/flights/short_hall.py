"""The world of the surveillance mission, in which the target is found a lap sooner.

It is seen on the first flight along there, not on the second, so a flight takes 45 s and not 71 s.
The vehicle has no range finder: the map is true, and scans are a quarter of a flight's work. All
else happens as in the shipped world: an event, a replan, a denial, another replan, home.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from lockstep import World

from sitl.world.scenario import read_scenario
from sitl.world.scenario_events import VisitTrigger

SHIPPED = Path(__file__).parents[2] / "missions" / "surveillance.sim.yaml"


def short_hall() -> World:
    """The world, and its true map."""
    return blind(seen_soon(read_scenario(SHIPPED)))


def seen_soon(world: World) -> World:
    """Such a world, in which the target is seen a lap sooner."""
    scenario, grid = world
    (seen,) = scenario.events
    assert isinstance(seen.trigger, VisitTrigger)
    soon = replace(seen, trigger=replace(seen.trigger, visit=1))
    return replace(scenario, events=(soon,)), grid


def blind(world: World) -> World:
    """A world whose vehicle has no range finder."""
    scenario, grid = world
    return replace(scenario, lidar=None), grid
