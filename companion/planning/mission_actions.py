"""The actions of one mission as they are now: with the costs of the present map.

Skills are instantiated when this is made. When the map changes, the moves are instantiated again:
with new costs, and without those that have no route. Between places, moves from `here` are added.
"""

from __future__ import annotations

import math
from dataclasses import replace

from companion.errors import RequestError
from companion.mission.facts import HERE, Fact
from companion.mission.model import Mission
from companion.mission.tree_nodes import Tree, actions
from companion.planning.domain import Action, is_named, reach
from companion.planning.instances import Drains, FlightTime, Instances, task_model


class MissionActions:
    """The instances of a mission's skills.

    Args:
        mission: the mission.
        flight_time: seconds between two places, or from `here` to a place; inf without a route.
        drains: how much energy actions take; None if that is ignored.

    Attributes:
        model: the actions that exist now, except moves from `here`, and all beliefs so far.
        flight_time: as given, or as the flight knows it.
        without_a_move: beliefs that only moves assumed, and these moves no longer exist.
    """

    def __init__(
        self, mission: Mission, flight_time: FlightTime, drains: Drains | None = None
    ) -> None:
        self._skills = Instances(mission, drains=drains)
        self._departures = Instances(mission, HERE, drains)
        self.model = task_model(self._skills, flight_time)
        self.flight_time = flight_time
        self.without_a_move: frozenset[Fact] = frozenset()

    def follow(self, flight_time: FlightTime) -> None:
        """From now on uses the times of a flight, which knows where the vehicle is."""
        self.flight_time = flight_time

    def reinstantiate(self) -> None:
        """Applies changed flight times. All beliefs so far remain beliefs."""
        model = task_model(self._skills, self.flight_time)
        beliefs = self.model.beliefs | model.beliefs
        self.without_a_move = beliefs - model.beliefs
        self.model = replace(model, beliefs=beliefs)

    def beliefs(self, is_en_route: bool) -> frozenset[Fact]:
        """All beliefs, unless they were disproved; between places, also those about `here`."""
        known = self.model.beliefs
        return known | self._departures.beliefs if is_en_route else known

    def departures(self, goal: str | None = None) -> tuple[Action, ...]:
        """The moves from `here` that exist now, to one place or to all."""

        def flight_time(origin: str, place: str) -> float:
            return self.flight_time(origin, place) if goal in (None, place) else math.inf

        return self._departures.actions(flight_time)

    def move_to(self, place: str) -> Action | None:
        """A flight from `here` to a place, whatever skills require; None without a route.

        It is a move of the mission if one flies there, otherwise the action `reach`.
        """
        move = next((a for a in self.departures(place) if a.execute == reach(place).execute), None)
        if move is not None:
            return replace(move, requires=frozenset(), forbids=frozenset(), assumes=frozenset())
        return reach(place) if math.isfinite(self.flight_time(HERE, place)) else None

    def every(self) -> tuple[Action, ...]:
        """All actions that exist now, and all moves from `here`."""
        return (*self.model.actions, *self._departures.actions(lambda origin, goal: 0.0))

    def of_tree(self, tree: Tree) -> dict[str, tuple[Action, ...]]:
        """The actions that a tree names; moves from `here` start wherever the vehicle is.

        An action from `*` stands for several: one from each place, and one from `here`.

        Raises:
            CompanionError: an action does not exist.
        """
        known = self.every()
        found = {name: tuple(a for a in known if is_named(a, name)) for name in actions(tree)}
        if missing := sorted(name for name, meant in found.items() if not meant):
            raise RequestError(f"the tree cannot do {missing[0]}: no such action, or no route")
        return found
