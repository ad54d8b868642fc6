"""Retries, of the steps of a skill and of a tree written by hand.

An action that fails and is tried again has not failed yet: its assumptions are still believed.
"""

from __future__ import annotations

from py_trees.behaviour import Behaviour
from py_trees.common import Status
from py_trees.decorators import Retry

from companion.acting.behaviour_tree.leaf import leaves_of
from companion.acting.flight import Flight


class RetrySteps(Retry):
    """Tries its child again after a failure, a limited number of times: MAX_TRY(m) of Fig. 6.

    Each try does all steps again, including those that were done in the failed try.
    """

    def __init__(self, flight: Flight, child: Behaviour, tries: int) -> None:
        super().__init__(f"MAX_TRY({tries})", child, tries)
        self._flight = flight

    def update(self) -> Status:
        """RUNNING before another try."""
        if self.decorated.status is Status.FAILURE:
            self._flight.steps.end_try({leaf.nth for leaf in leaves_of(self.decorated)})
        return super().update()


class RetryByHand(RetrySteps):
    """A retry in a tree written by hand.

    Attributes:
        began_on_ground: whether the first try began on the ground.
    """

    def __init__(self, flight: Flight, child: Behaviour, tries: int) -> None:
        super().__init__(flight, child, tries)
        self.name = f"retry {tries}"
        self.began_on_ground = False

    def initialise(self) -> None:
        """Begins with the first try."""
        super().initialise()
        self.began_on_ground = self._flight.progress.is_landed_by_plan

    def terminate(self, new_status: Status) -> None:
        """Ends the retries: after an interruption from above there is no other try."""
        if new_status is Status.INVALID:
            self.failures = self.num_failures

    @property
    def has_another(self) -> bool:
        """Whether another try follows if the present one fails."""
        return self.failures + 1 < self.num_failures


class Tries:
    """The retries around a part of the tree; the builder makes them after that part.

    Args:
        around: the retries around the innermost one.
    """

    def __init__(self, around: Tries | None = None) -> None:
        self._around = around
        self.retry: RetryByHand | None = None

    @property
    def is_any(self) -> bool:
        """Whether there is any retry."""
        return self.retry is not None

    @property
    def next(self) -> RetryByHand | None:
        """The innermost retry that would try again after a failure now; None if there is none."""
        if self.retry is not None and self.retry.has_another:
            return self.retry
        return self._around.next if self._around is not None else None
