"""The flight home that an operator asks for, whatever the task says.

It leads to the place where the mission begins, along a clear route of the map as it is known
now. No event is watched and nothing is planned: nobody but the operator may change this.
"""

from __future__ import annotations

from dataclasses import replace

from py_trees.common import Status

from companion.acting.behaviour_tree.builder import move_tree
from companion.acting.behaviour_tree.leaf import failure_of
from companion.acting.flight import Flight
from companion.mission.facts import Fact
from companion.mission.model import Fly
from companion.planning.domain import WAIT
from companion.planning.lasso import Lasso
from companion.planning.planner import Planner
from companion.vehicle.port import Failed, Outcome, Progress

TRIES = 3
"""Waypoints of the place that are tried (MAX_TRY, Fig. 6)."""


class ReturnHome:
    """A flight to one place."""

    def __init__(self, flight: Flight, place: str) -> None:
        self._tree = move_tree(flight, place, TRIES, timeout_s=None)

    def tick(self) -> Outcome:
        """One tick: RUNNING on the way, DONE at the place, Failed without a clear route."""
        self._tree.tick_once()
        if self._tree.status is Status.FAILURE:
            return Failed(failure_of(self._tree))
        return Progress.DONE if self._tree.status is Status.SUCCESS else Progress.RUNNING

    def stop(self) -> None:
        """Holds where it is; the next tick begins anew."""
        self._tree.stop(Status.INVALID)


def flight_to(planner: Planner, place: str) -> Lasso | None:
    """A plan that flies to a place from where the vehicle is, and rests; None without a route.

    It asks for nothing that the skill that flies there would ask for otherwise.
    """
    moves = planner.departures(place)
    move = next((action for action in moves if action.execute == (Fly(place),)), None)
    if move is None:
        return None
    nothing: frozenset[Fact] = frozenset()
    return Lasso((replace(move, requires=nothing, forbids=nothing, assumes=nothing),), (WAIT,))
