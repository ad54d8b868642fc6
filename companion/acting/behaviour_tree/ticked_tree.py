"""A behaviour tree that is ticked, together with the reports about its nodes."""

from __future__ import annotations

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from companion.acting.behaviour_tree import pausing
from companion.acting.behaviour_tree.leaf import failure_of
from companion.acting.behaviour_tree.tree_report import TreeReport
from companion.acting.flight import Flight


class TickedTree:
    """One tree of a flight.

    Args:
        flight: receives the reports.
        root: the tree.
    """

    def __init__(self, flight: Flight, root: Behaviour) -> None:
        self._flight, self._root = flight, root
        self._report = TreeReport(flight, root)
        self._paused_s = 0.0

    @property
    def has_succeeded(self) -> bool:
        """Whether it is done."""
        return self._root.status is Status.SUCCESS

    @property
    def has_failed(self) -> bool:
        """Whether it has failed."""
        return self._root.status is Status.FAILURE

    @property
    def failure(self) -> str:
        """Why it has failed; "" if it has not, or if a leaf gave no reason."""
        return failure_of(self._root)

    def tick(self) -> None:
        """Ticks it once."""
        self._root.tick_once()

    def tell(self) -> None:
        """Reports changes in the status of its nodes."""
        self._report.tell()

    def stop(self) -> None:
        """Ends what is under way; the next tick begins anew."""
        self._root.stop(Status.INVALID)
        self.tell()

    def pause(self) -> None:
        """Interrupts what is under way, to continue it later."""
        self._paused_s = self._flight.now_s
        pausing.pause(self._root)
        self.tell()

    def resume(self) -> None:
        """Lets the next tick continue after a pause."""
        pausing.resume(self._root, self._flight.now_s - self._paused_s)
