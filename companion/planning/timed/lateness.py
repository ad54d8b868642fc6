"""Explains which bounds cannot be kept, and from which limit on they could be kept.

Each bound is relaxed until there is a plan, with all other bounds unchanged. Searches between a
limit without a plan and what a plan with a longer limit takes find the least limit.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from companion.errors import SearchLimit
from companion.ltl.time_bounds import MARGIN_MS, MARGIN_PERCENT
from companion.planning.domain import UNIT_MS
from companion.planning.effort import Effort
from companion.planning.lasso import Problem
from companion.planning.time_check import LongestWait, longest_waits
from companion.planning.timed.search import TimedSearch

NO_LIMIT_MS = 1_000_000_000
MOST_STOPS = 8
SHARES = 10
"""The effort is divided by this for each search; a bound needs about a dozen searches."""


def late_bounds(search: TimedSearch, problem: Problem, effort: Effort) -> tuple[str, ...]:
    """A line for each bound that would have to be relaxed; none if that would not help.

    Args:
        search: knows the mission's actions and automata.
        problem: a problem without a plan.
        effort: the limits of each search.
    """
    effort = replace(effort, time_labels=effort.time_labels // SHARES)
    bounded = [n for n, each in enumerate(problem.conjuncts) if each.bound is not None]
    return tuple(line for number in bounded for line in _relaxed(search, problem, number, effort))


def _relaxed(search: TimedSearch, problem: Problem, number: int, effort: Effort) -> Iterator[str]:
    conjunct = problem.conjuncts[number]
    assert conjunct.bound is not None
    planned_ms = low_ms = conjunct.bound.planned_ms
    best: LongestWait | None = None
    try:
        best = _waiting(search, problem, number, NO_LIMIT_MS, effort)
        if best is None:
            return
        while best.elapsed_ms - low_ms > UNIT_MS:
            middle_ms = (low_ms + best.elapsed_ms) // 2
            found = _waiting(search, problem, number, _limit_ms(middle_ms), effort)
            low_ms, best = (middle_ms, best) if found is None else (low_ms, found)
        how = "from"
    except SearchLimit:
        if best is None:
            return
        how = "at the latest from"
    limit_ms = -(-_limit_ms(best.elapsed_ms) // UNIT_MS) * UNIT_MS
    more_s = (best.elapsed_ms - planned_ms) / 1000
    yield (
        f"{conjunct.text} cannot be kept: {_stops(best)} takes {best.elapsed_ms / 1000:g} s, "
        f"{more_s:g} s more than is planned for; {how} {limit_ms / 1000:g} s on it can be"
    )


def _waiting(
    search: TimedSearch, problem: Problem, number: int, limit_ms: int, effort: Effort
) -> LongestWait | None:
    """The longest wait for a bound in a plan, if the bound had another limit; None without a plan.

    Raises:
        SearchLimit: it is unknown whether there is a plan.
    """
    asked = with_limit(problem, number, limit_ms)
    other = asked.conjuncts[number]
    solution = next(search.solutions(asked, effort), None)
    if solution is None:
        return None
    waits = longest_waits(asked, solution.lasso)
    return next((wait for wait in waits if wait.conjunct is other), LongestWait(other, 0, ()))


def with_limit(problem: Problem, number: int, limit_ms: int) -> Problem:
    """The problem with another limit for the bound of one conjunct."""
    conjunct = problem.conjuncts[number]
    assert conjunct.bound is not None
    other = replace(conjunct, bound=replace(conjunct.bound, limit_ms=limit_ms))
    conjuncts = (*problem.conjuncts[:number], other, *problem.conjuncts[number + 1 :])
    return replace(problem, conjuncts=conjuncts)


def _limit_ms(planned_ms: int) -> int:
    """The least limit for which plans keep this limit."""
    percent = 100 - MARGIN_PERCENT
    return max(planned_ms + MARGIN_MS, -(-planned_ms * 100 // percent))


def _stops(wait: LongestWait) -> str:
    places = wait.places
    if len(places) <= MOST_STOPS:
        return ", ".join(places)
    return f"{', '.join(places[: MOST_STOPS - 2])}, ..., {places[-1]}"
