"""Flies a shipped mission in lockstep, and reads the word that it flew from what was reported.

The word is made anew from the reports, with the skills' effects as the mission file has them: no
automaton, no task state and no planner takes part. So a line of the task held in the flight if
the semantics of LTL says so of the word.
"""

from __future__ import annotations

import math
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

from lockstep import Lockstep

from companion.flight_events.event import FlightEvent
from companion.flight_events.facts import BeliefWithdrawn, MissionEventChanged
from companion.flight_events.plans import LineDropped, LineTakenUp, NoPlanFound, PlanReplaced
from companion.flight_events.skills import (
    PlaceReached,
    RouteBlocked,
    SkillCompleted,
    SkillFailed,
)
from companion.flight_events.sortie import RunEnded
from companion.geometry import Ned, distance
from companion.ltl.semantics import holds
from companion.ltl.timed_formula import untimed
from companion.mission.facts import Fact
from companion.mission.loader import load_mission
from companion.mission.model import Mission
from companion.mission.steps import Fly
from companion.planning.domain import Action
from companion.planning.instances import departures, instantiate
from companion.planning.lasso import Letter
from companion.tick import TICK_S
from sitl.world.scenario import read_scenario

MISSIONS = Path(__file__).parents[2] / "missions"
TOLD = (
    *(MissionEventChanged, SkillCompleted, SkillFailed, BeliefWithdrawn, RouteBlocked, RunEnded),
    *(LineDropped, LineTakenUp),
)


class Replanned(NamedTuple):
    """A replan, whatever the plan."""

    reason: str


Story = list[FlightEvent | Replanned | str]
"""What happened, in short; a string is a place that was reached."""


class ShippedFlight(Lockstep):
    """A mission of missions/ in the world of a scenario there, flown to its end.

    Args:
        mission, scenario: their names.
        limit_s: what the flight takes at most.
        until: a place at which it is left alone when it has come there; "" for the end.

    Attributes:
        mission: the mission.
        truth: where the vehicle truly was at each tick.
        clearance_m: from the vehicle's centre to the nearest wall or obstacle that was truly there,
            at worst.
        velocities: how it truly moved at each tick in OFFBOARD; None at the others.
    """

    def __init__(
        self, mission: str, scenario: str, seed: int, limit_s: float = 150.0, until: str = ""
    ) -> None:
        self.mission = load_mission(MISSIONS / f"{mission}.yaml")
        self.truth: list[Ned] = []
        self.clearance_m = math.inf
        self.velocities: list[Ned | None] = []
        super().__init__(self.mission, read_scenario(MISSIONS / f"{scenario}.sim.yaml"), seed=seed)
        self.until(lambda: self.companion.has_ended or until in self.places, limit_s)

    def tick(self) -> None:
        super().tick()
        position = self.simulation.flight.position
        self.truth.append(position)
        is_ours = self.simulation.mode == "OFFBOARD" and self.simulation.is_armed
        self.velocities.append(self.simulation.flight.velocity if is_ours else None)
        assert self.simulation.true_map is not None
        self.clearance_m = min(self.clearance_m, self.simulation.true_map.clearance_m(position[:2]))

    @property
    def speed_mps(self) -> float:
        """The greatest true speed in OFFBOARD."""
        return max(math.hypot(*velocity) for velocity in self.velocities if velocity)

    @property
    def acceleration_mps2(self) -> float:
        """The greatest true acceleration in OFFBOARD, over two ticks."""
        pairs = zip(self.velocities, self.velocities[2:], strict=False)
        return max(distance(a, b) / (2 * TICK_S) for a, b in pairs if a and b)

    def crossings(self, east_m: float) -> list[float]:
        """Where the vehicle crossed a line from south to north: metres north, in order."""
        return [
            (a[0] + b[0]) / 2 for a, b in pairwise(self.truth) if (a[1] < east_m) != (b[1] < east_m)
        ]

    @property
    def story(self) -> Story:  # type: ignore[override]
        """What happened, in short: why it replanned, and not to what."""
        found: Story = []
        for event in self.events:
            match event:
                case PlaceReached():
                    found.append(event.place)
                case PlanReplaced() | NoPlanFound():
                    found.append(Replanned(event.reason))
                case _ if isinstance(event, TOLD):
                    found.append(event)
        return found

    def lines_that_hold(self) -> list[str]:
        """Lines of the task that the flown word satisfies, if it rests at its end for ever.

        Bounds in time are not asked: one that passed would have been told.

        A line that an event restarts is about the word from that event on.
        """
        word, since = flown_word(self)
        events = self.mission.events
        begins = {
            line: max((n for e, n in since.items() if line in events[e].restarts), default=0)
            for line in self.mission.task
        }
        return [
            line
            for line, said in self.mission.task.items()
            if holds(untimed(said), word[begins[line] :], word[-1:])
        ]


def flown_word(flight: ShippedFlight) -> tuple[list[Letter], dict[str, int]]:
    """The letters of the positions, and for each event the first position that is after it.

    A completed skill appends a position. An event on the way is part of the position that is
    reached next.
    """
    actions = {action.name: action for action in _actions(flight.mission)}
    facts = flight.mission.initially
    word = [facts]
    since: dict[str, int] = {}
    for event in flight.events:
        match event:
            case MissionEventChanged(event=name, holds=holds):
                fact = Fact.parse(name)
                facts = facts | {fact} if holds else facts - {fact}
                since[name] = len(word)
            case PlaceReached(action=name) | SkillCompleted(action=name):
                action = actions[name]
                if isinstance(action.execute, Fly):  # the vehicle may come from between places
                    facts = frozenset(fact for fact in facts if not fact.startswith("at("))
                facts = action.apply(facts)
                word.append(facts)
    return word, since


def _actions(mission: Mission) -> tuple[Action, ...]:
    """All ground skills, flights from between places among them."""

    def one_second(origin: str, goal: str) -> float:
        return 1.0

    return (*instantiate(mission, one_second).actions, *departures(mission, one_second))


def distance_from_home_m(flight: ShippedFlight) -> float:
    """Of the vehicle at the end, from the place on the ground below Home."""
    north, east, _ = flight.mission.home.position
    return distance(flight.truth[-1], (north, east, 0.0))
