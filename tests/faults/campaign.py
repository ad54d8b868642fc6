"""Seeds of a fault campaign, and shipped missions in worlds with faults."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace
from functools import cache
from itertools import product
from pathlib import Path
from typing import Any

import pytest
from lockstep import Air, Lockstep, World, clear
from short_hall import short_hall

from companion.flight_events.event import FlightEvent
from companion.flight_events.skills import PlaceReached, SkillCompleted, SkillFailed
from companion.flight_events.sortie import RunEnded
from companion.mission.loader import load_mission
from companion.mission.model import Mission
from sitl.world.scenario import read_scenario

MISSIONS = Path(__file__).parents[2] / "missions"
LONGEST_S = 400.0
"""More than any of these missions takes, also with loss."""
ACTIONS = (PlaceReached, SkillCompleted, SkillFailed, RunEnded)


def sweep(*axes: Iterable[Any], few: Callable[..., bool]) -> list[Any]:
    """All combinations as parameters; a few fly with all tests, the others where asked for."""
    return [
        pytest.param(*case, marks=[] if few(*case) else [pytest.mark.long])
        for case in product(*axes)
    ]


@cache
def shipped(name: str) -> Mission:
    """A mission of missions/."""
    return load_mission(MISSIONS / f"{name}.yaml")


def world(name: str, *faults: dict[str, Any]) -> World:
    """The world of a shipped mission, the short hall for surveillance, with faults: `happens`."""
    read = short_hall() if name == "surveillance" else read_scenario(MISSIONS / f"{name}.sim.yaml")
    scenario, grid = read
    added, _ = read_scenario({"version": 1, "happens": [*faults]})
    return replace(scenario, events=(*added.events, *scenario.events)), grid


def begin(
    name: str, *faults: dict[str, Any], seed: int = 0, up: Air = clear, down: Air = clear
) -> Lockstep:
    """A shipped mission with faults, to be flown."""
    return Lockstep(shipped(name), world(name, *faults), seed=seed, up=up, down=down)


def fly(
    name: str, *faults: dict[str, Any], seed: int = 0, up: Air = clear, down: Air = clear
) -> Lockstep:
    """A shipped mission with faults, flown to its end."""
    flight = begin(name, *faults, seed=seed, up=up, down=down)
    return flight.until(lambda: flight.companion.has_ended, LONGEST_S)


@cache
def undisturbed(name: str) -> Lockstep:
    """The mission without any fault."""
    return fly(name)


def actions(flight: Lockstep) -> list[FlightEvent]:
    """What was done, in order, and the end."""
    return [event for event in flight.events if isinstance(event, ACTIONS)]


def modes(flight: Lockstep) -> list[str]:
    """The modes that were flown, in order."""
    return [mode for _, mode in flight.modes]
