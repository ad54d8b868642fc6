"""What takes several searches in flight: a few of them in each tick, while the vehicle holds.

Why a task has no plan takes a search per conjunct and per withdrawn belief: 0.3 s with 20 sites,
too long for setpoints to wait. Which lines of it can be kept takes a search per optional line.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import islice
from typing import Generic, TypeVar

from companion.planning.lasso import Problem

SEARCHES_PER_TICK = 2
"""One takes 4 ms with 20 sites."""

T = TypeVar("T")


class SearchInParts(Generic[T]):
    """Finds out something about a problem.

    Args:
        problem: from where.
        parts: a search each; None until the answer is known, then the answer.
    """

    def __init__(self, problem: Problem, parts: Iterator[T | None]) -> None:
        self._about = what_decides(problem)
        self._parts = parts
        self._answer: T | None = None

    def is_about(self, problem: Problem) -> bool:
        """Whether a problem differs from this one in nothing but costs, which change in the air."""
        return self._about == what_decides(problem)

    def step(self) -> T | None:
        """The part of a tick; the answer once it is known."""
        parts = islice(self._parts, SEARCHES_PER_TICK) if self._answer is None else ()
        for answer in parts:
            self._answer = answer
        return self._answer


def what_decides(problem: Problem) -> tuple[object, ...]:
    """All of a problem that decides on whether there is a plan."""
    actions = tuple(action.name for action in problem.actions)
    return actions, problem.facts, problem.withdrawn, problem.automaton_states
