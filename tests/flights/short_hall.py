"""The world of the surveillance mission, in which the target is found a lap sooner.

It is seen on the first flight along there, not on the second, so a flight takes 45 s and not 71 s.
All else happens as in the shipped world: an event, a replan, a denial, another replan, home.
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
    scenario, grid = read_scenario(SHIPPED)
    (seen,) = scenario.events
    assert isinstance(seen.trigger, VisitTrigger)
    soon = replace(seen, trigger=replace(seen.trigger, visit=1))
    return replace(scenario, events=(soon,)), grid
