"""The independent check of a plan's bounds in time: it is flown on paper, by the clocks themselves.

No search takes part, and the limits are those of the task: what plans keep in hand is not asked.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from companion.planning.bound_clocks import after
from companion.planning.domain import Action, duration_ms
from companion.planning.lasso import Conjunct, Lasso, Letter, Problem
from companion.slices import spent

_READING_US = 10.0


@dataclass(frozen=True, slots=True)
class _Arrival:
    """A clock that runs where a position is reached.

    Attributes:
        number: of its conjunct.
        elapsed_ms: what it shows before the position is read.
        actions: since it began, or since the start of the plan.
    """

    number: int
    elapsed_ms: int
    actions: tuple[Action, ...]


@dataclass(frozen=True, slots=True)
class LongestWait:
    """The longest that a bounded line waits in a plan.

    Attributes:
        elapsed_ms: what its clock shows at most.
        actions: meanwhile, as far as the plan has them.
    """

    conjunct: Conjunct
    elapsed_ms: int
    actions: tuple[Action, ...]

    @property
    def slack_ms(self) -> int:
        """What is left of the limit."""
        assert self.conjunct.bound is not None
        return self.conjunct.bound.limit_ms - self.elapsed_ms


def time_fault(problem: Problem, lasso: Lasso) -> str | None:
    """What is late in a plan that is flown for ever, in words; None if nothing is.

    Args:
        problem: that the plan solves.
        lasso: the plan.
    """
    for arrival in _arrivals(problem, lasso):
        conjunct = problem.conjuncts[arrival.number]
        bound = conjunct.bound
        assert bound is not None
        if bound.is_late(arrival.elapsed_ms):
            over_s = (arrival.elapsed_ms - bound.limit_ms) / 1000
            reached_by = arrival.actions[-1].name
            return f"{conjunct.name}: {bound} is late by {over_s:g} s after {reached_by}"
    return None


def longest_waits(problem: Problem, lasso: Lasso) -> tuple[LongestWait, ...]:
    """For each bounded conjunct whose clock runs in a plan, the longest that it waits.

    Args:
        problem: that the plan solves.
        lasso: the plan, which keeps all bounds.
    """
    longest: dict[int, LongestWait] = {}
    for arrival in _arrivals(problem, lasso):
        known = longest.get(arrival.number)
        if known is None or arrival.elapsed_ms > known.elapsed_ms:
            conjunct = problem.conjuncts[arrival.number]
            longest[arrival.number] = LongestWait(conjunct, arrival.elapsed_ms, arrival.actions)
    return tuple(longest[number] for number in sorted(longest))


def _arrivals(problem: Problem, lasso: Lasso) -> Iterator[_Arrival]:
    """The clocks that run at each position, until laps begin with clocks as before.

    A clock that is late goes on for no more than a lap.
    """
    bounded = {n: c.bound for n, c in enumerate(problem.conjuncts) if c.bound is not None}
    clocks = {number: problem.clocks_ms[number] for number in bounded}
    since: dict[int, tuple[Action, ...]] = dict.fromkeys(bounded, ())
    facts, unread = problem.facts, problem.unread
    before: Mapping[int, int | None] | None = None
    actions = lasso.prefix
    while True:
        for action in actions:
            facts = action.apply(facts)
            letter: Letter = facts | unread
            unread = frozenset()
            spent(_READING_US * len(bounded))
            for number, bound in bounded.items():
                elapsed_ms = clocks[number]
                if elapsed_ms is not None:
                    elapsed_ms += duration_ms(action)
                    since[number] = (*since[number], action)
                    yield _Arrival(number, elapsed_ms, since[number])
                shown = after(bound, elapsed_ms, letter)
                if shown is None or not shown:
                    since[number] = ()
                clocks[number] = shown
        is_late = any(bound.is_late(clocks[number]) for number, bound in bounded.items())
        if clocks == before or (is_late and before is not None):
            return
        before = dict(clocks)
        actions = lasso.loop
