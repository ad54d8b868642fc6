"""The independent check of a plan's time bounds: it executes the plan with the clocks, without
search.

The limits are those of the task; the margin that planning adds is not checked.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from companion.planning.bound_clocks import after
from companion.planning.domain import Action, duration_ms
from companion.planning.energy_check import level_after, place_of
from companion.planning.lasso import Conjunct, Lasso, Letter, Problem, Solution
from companion.planning.optional_lines import without_lines
from companion.slices import spent

_READING_US = 10.0


@dataclass(frozen=True, slots=True)
class _Arrival:
    """A clock that runs when a position is reached.

    Attributes:
        number: index of its conjunct.
        elapsed_ms: what it shows before the position is read.
        places: places since it began, or since the start of the plan.
        action: the action that led to the position.
    """

    number: int
    elapsed_ms: int
    places: tuple[str, ...]
    action: Action


@dataclass(frozen=True, slots=True)
class LongestWait:
    """The longest wait of a bounded line in a plan.

    Attributes:
        elapsed_ms: the most that its clock shows.
        places: from where the clock (or the plan) began to where the wait ends.
    """

    conjunct: Conjunct
    elapsed_ms: int
    places: tuple[str, ...]

    def __str__(self) -> str:
        return (
            f"{self.conjunct.name}: {self.conjunct.text}: {self.elapsed_ms / 1000:.1f} s at most, "
            f"{self.slack_ms / 1000:.1f} s to spare: {', '.join(self.places)}"
        )

    @property
    def slack_ms(self) -> int:
        """The rest of the limit."""
        assert self.conjunct.bound is not None
        return self.conjunct.bound.limit_ms - self.elapsed_ms

    def as_json(self) -> dict[str, object]:
        """The wait as JSON values."""
        return {
            "line": self.conjunct.name,
            "formula": self.conjunct.text,
            "longest_s": self.elapsed_ms / 1000,
            "slack_s": self.slack_ms / 1000,
            "places": list(self.places),
        }


@dataclass(frozen=True, slots=True)
class LateLine:
    """A line that a plan keeps too late.

    Attributes:
        is_over: whether it is later than its limit.
        text: how late it is, and after which action, in words.
    """

    line: str
    is_over: bool
    text: str


def time_fault(problem: Problem, lasso: Lasso) -> str | None:
    """What is late if a plan is flown for ever, in words; None if nothing is.

    Args:
        problem: the problem that the plan solves.
        lasso: the plan.
    """
    first = next(late_lines(problem, lasso), None)
    return None if first is None else first.text


def late_lines(problem: Problem, lasso: Lasso, is_watched: bool = False) -> Iterator[LateLine]:
    """The lines that are late if a plan is flown for ever, in the order of time.

    Args:
        problem: the problem that the plan solves.
        lasso: the plan.
        is_watched: whether lines count that keep less than half of the margin of plans.
    """
    for arrival in _arrivals(problem, lasso):
        conjunct = problem.conjuncts[arrival.number]
        bound = conjunct.bound
        assert bound is not None
        if arrival.elapsed_ms > (bound.watched_ms if is_watched else bound.limit_ms):
            spare_s = (bound.limit_ms - arrival.elapsed_ms) / 1000
            how = f"is late by {-spare_s:g} s" if spare_s < 0 else f"has {spare_s:g} s to spare"
            text = f"{conjunct.name}: {bound} {how} after {arrival.action.name}"
            yield LateLine(conjunct.name, spare_s < 0, text)


def waits(problem: Problem, solution: Solution) -> tuple[LongestWait, ...]:
    """The longest wait of each line with a time bound that the plan keeps."""
    kept, _ = without_lines([each.line for each in solution.dropped], problem)
    return longest_waits(kept, solution.lasso) if kept.clocks_ms else ()


def longest_waits(problem: Problem, lasso: Lasso) -> tuple[LongestWait, ...]:
    """The longest wait of each bounded conjunct whose clock runs in a plan.

    Args:
        problem: the problem that the plan solves.
        lasso: the plan; it keeps all bounds.
    """
    longest: dict[int, LongestWait] = {}
    for arrival in _arrivals(problem, lasso):
        known = longest.get(arrival.number)
        if known is None or arrival.elapsed_ms > known.elapsed_ms:
            conjunct = problem.conjuncts[arrival.number]
            longest[arrival.number] = LongestWait(conjunct, arrival.elapsed_ms, arrival.places)
    return tuple(longest[number] for number in sorted(longest))


def _arrivals(problem: Problem, lasso: Lasso) -> Iterator[_Arrival]:
    """The clocks that run at each position, until a lap begins with the same clocks as one before.

    A clock that is late is followed for one more lap at most.
    """
    bounded = {n: c.bound for n, c in enumerate(problem.conjuncts) if c.bound is not None}
    clocks = {number: problem.clocks_ms[number] for number in bounded}
    facts, unread = problem.facts, problem.unread
    begun: tuple[str, ...] = (place_of(facts),)
    passed = dict.fromkeys(bounded, begun)
    level = problem.energy.level if problem.energy is not None else 0
    before: tuple[Mapping[int, int | None], int] | None = None
    actions = lasso.prefix
    while True:
        for action in actions:
            took_ms = _duration_ms(action, level)
            if problem.energy is not None:
                level = level_after(problem.energy, level, action)
            facts = action.apply(facts)
            letter: Letter = facts | unread
            place = place_of(facts)
            unread = frozenset()
            spent(_READING_US * len(bounded))
            for number, bound in bounded.items():
                elapsed_ms = clocks[number]
                if elapsed_ms is not None:
                    elapsed_ms += took_ms
                    if passed[number][-1] != place:
                        passed[number] = (*passed[number], place)
                    yield _Arrival(number, elapsed_ms, passed[number], action)
                shown = after(bound, elapsed_ms, letter)
                if not shown:
                    passed[number] = (place,)
                clocks[number] = shown
        is_late = any(bound.is_late(clocks[number]) for number, bound in bounded.items())
        charges = any(action.charge_to is not None for action in lasso.loop)
        now = clocks, level if charges else 0  # else it only falls and never matters
        if now == before or (is_late and before is not None):
            return
        before = dict(clocks), now[1]
        actions = lasso.loop


def _duration_ms(action: Action, level: int) -> int:
    """The duration of an action; of a charge, if it begins with this level."""
    if action.charger is None or action.charge_to is None:
        return duration_ms(action)
    return action.charger.service_ms(level, action.charge_to)
