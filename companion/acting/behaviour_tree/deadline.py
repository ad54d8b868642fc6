"""A time limit for a part of the tree, in the flight's own time, unlike py_trees' timeout."""

from __future__ import annotations

from py_trees.behaviour import Behaviour
from py_trees.common import Status
from py_trees.decorators import Decorator

from companion.acting.flight import Flight


class Deadline(Decorator):
    """Fails after `timeout_s`, and stops the part below."""

    def __init__(self, flight: Flight, child: Behaviour, timeout_s: float) -> None:
        super().__init__(f"within {timeout_s:g} s", child)
        self._flight = flight
        self.timeout_s = timeout_s
        self._end_s = 0.0

    def initialise(self) -> None:
        """Starts the timer."""
        self._end_s = self._flight.now_s + self.timeout_s

    def postpone(self, duration_s: float) -> None:
        """Extends the limit by the time of a pause."""
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
