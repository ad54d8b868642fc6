"""How does a vehicle get home when the operator calls it, whatever its task says?

By a flight to the place where the mission begins, along a clear route of the map as it is known
now. No event is watched and nothing is planned: nobody but the operator may change this.
"""

from __future__ import annotations

from py_trees.common import Status
from py_trees.composites import Sequence
from py_trees.decorators import Retry

from companion.acting.behaviour_tree.leaves import UpdateParam
from companion.acting.behaviour_tree.move import MoveCommand
from companion.acting.flight import Flight

TRIES = 3
"""Waypoints of the place that are tried (MAX_TRY, Fig. 6)."""


class ReturnHome:
    """A flight to one place."""

    def __init__(self, flight: Flight, place: str) -> None:
        move = Sequence("move", memory=True)
        move.add_children([UpdateParam(flight, place), MoveCommand(flight, place, None)])
        self._tree = Retry(f"MAX_TRY({TRIES})", move, TRIES)

    def tick(self) -> Status:
        """One tick: RUNNING on the way, SUCCESS at the place, FAILURE without a clear route."""
        self._tree.tick_once()
        return self._tree.status

    def stop(self) -> None:
        """Holds where it is; the next tick begins anew."""
        self._tree.stop(Status.INVALID)
