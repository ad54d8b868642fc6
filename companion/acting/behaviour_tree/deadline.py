"""A time limit over a part of the tree, in the flight's own time; py_trees' is the wall clock's."""

from __future__ import annotations

from py_trees.behaviour import Behaviour
from py_trees.common import Status
from py_trees.decorators import Decorator

from companion.acting.flight import Flight


class Deadline(Decorator):
    """Fails, and stops what is below, after a time: `timeout_s`."""

    def __init__(self, flight: Flight, child: Behaviour, timeout_s: float) -> None:
        super().__init__(f"within {timeout_s:g} s", child)
        self._flight = flight
        self.timeout_s = timeout_s
        self._end_s = 0.0

    def initialise(self) -> None:
        """Starts the time."""
        self._end_s = self._flight.now_s + self.timeout_s

    def postpone(self, duration_s: float) -> None:
        """The time of a pause does not count."""
        self._end_s += duration_s

    def update(self) -> Status:
        """The child's status, until the time is over."""
        if self.decorated.status is Status.RUNNING and self._flight.now_s > self._end_s:
            tip = self.decorated.tip()
            about = tip.feedback_message if tip is not None else ""
            self.decorated.stop(Status.INVALID)
            self.feedback_message = f"not done after {self.timeout_s:g} s" + (
                f": {about}" if about else ""
            )
            return Status.FAILURE
        return self.decorated.status
