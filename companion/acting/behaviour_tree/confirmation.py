"""The leaf that waits, after the last step of a skill, for the reading that confirms it."""

from __future__ import annotations

from py_trees.common import Status

from companion.acting.behaviour_tree.leaf import Leaf
from companion.acting.flight import Flight
from companion.flight_events.tree import LeafType
from companion.mission.signals import Condition

CONFIRM_S = 10.0
"""Time for the confirmation, if the skill gives none."""


class Confirm(Leaf):
    """Holds until a reading meets a condition.

    Earlier readings confirm nothing, unless the last step was done before an interruption: then all
    readings since that step count.

    Args:
        flight: what it acts on.
        condition: the condition to be met.
        timeout_s: the time of the skill; None for CONFIRM_S.
    """

    does = LeafType.CONFIRM

    def __init__(self, flight: Flight, condition: Condition, timeout_s: float | None) -> None:
        super().__init__(flight, f"confirmed by {condition}")
        self._condition = condition
        self._limit_s = CONFIRM_S if timeout_s is None else timeout_s

    def initialise(self) -> None:
        """Starts the timer."""
        self._begun_s = now_s = self._flight.now_s
        self._since_s = self._flight.steps.since_s(self.owner().action, now_s)

    def update(self) -> Status:
        """SUCCESS once such a reading was heard."""
        flight, condition = self._flight, self._condition
        flight.guidance.hold()
        heard_s, value = flight.heard.get(condition.signal, (self._since_s, None))
        is_new = heard_s > self._since_s
        if is_new and condition.is_met_by(value):
            return Status.SUCCESS
        last = f"it says {value:g}" if is_new and value is not None else "nothing is heard of it"
        self.feedback_message = f"not confirmed by {condition}: {last}"
        return Status.FAILURE if flight.now_s - self._begun_s > self._limit_s else Status.RUNNING
