"""The flight home that an operator requests, whatever the task says.

It leads along a clear route of the present map to the place where the mission begins, or to which a
low battery calls the vehicle. No event is watched and nothing is planned: only the operator may
change this flight.
"""

from __future__ import annotations

from py_trees.common import Status

from companion.acting.behaviour_tree.builder import move_tree
from companion.acting.behaviour_tree.leaf import failure_of
from companion.acting.flight import Flight
from companion.outcomes import Failed, Outcome, Progress
from companion.planning.domain import TRIES


class ReturnHome:
    """A flight to one place.

    Attributes:
        place: its name.
    """

    def __init__(self, flight: Flight, place: str) -> None:
        self.place = place
        self._tree = move_tree(flight, place, TRIES, timeout_s=None)

    def tick(self) -> Outcome:
        """One tick: RUNNING on the way, DONE at the place, Failed if there is no clear route."""
        self._tree.tick_once()
        if self._tree.status is Status.FAILURE:
            return Failed(failure_of(self._tree))
        return Progress.DONE if self._tree.status is Status.SUCCESS else Progress.RUNNING

    def stop(self) -> None:
        """Holds where the vehicle is; the next tick starts again."""
        self._tree.stop(Status.INVALID)
