"""Components without a lap are searched once: at every other place the answer is known."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import pytest
from problems import action, problem
from timed_problems import later, timed_problem, with_bounds

from companion.ltl.parser import parse
from companion.ltl.time_bounds import Revisit, TimeBound
from companion.mission.facts import at
from companion.planning.builtin.search import Search
from companion.planning.effort import IN_FLIGHT, Effort
from companion.planning.energy.search import BatterySearch
from companion.planning.lasso import Problem
from companion.planning.timed import lassos
from companion.planning.timed.lap_search import LapSearch
from companion.planning.timed.search import TimedSearch

LEGS = {(a, b): 10.0 if "H" in (a, b) else 20.0 for a in "HABC" for b in "HABC" if a != b}
"""H is in the middle of three sites; a tour takes 60 s, and any two of them 40 s."""
TOO_SHORT_S, LONG_ENOUGH_S = 55.0, 70.0
LITTLE = replace(IN_FLIGHT, time_labels=20)
"""Too little to look at all laps of the patrol."""


@pytest.fixture
def searches(monkeypatch: pytest.MonkeyPatch) -> list[LapSearch]:
    """The searches for laps that are made."""
    made: list[LapSearch] = []

    def noted(*arguments: object, **keys: object) -> LapSearch:
        made.append(LapSearch(*arguments, **keys))  # type: ignore[arg-type]
        return made[-1]

    monkeypatch.setattr(lassos, "LapSearch", noted)
    return made


def patrol(
    seconds: float, place: str = "H", legs: Mapping[tuple[str, str], float] = LEGS
) -> Problem:
    """A patrol, each site of which is visited again within some seconds."""
    bound = round(1000 * seconds)
    bounds: dict[str, TimeBound] = {p: Revisit(parse(f"at({p})"), bound) for p in "ABC"}
    return with_bounds(problem("HABC", legs, "patrolling(A, B, C)"), bounds, frozenset({at(place)}))


def seen(of: Problem, place: str, clock_ms: int) -> Problem:
    """The same from another place, with clocks that have run for some time."""
    clocks_ms = tuple(None if each is None else clock_ms for each in of.clocks_ms)
    facts = frozenset(fact for fact in of.facts if fact.predicate != "at") | {at(place)}
    return replace(of, facts=facts, clocks_ms=clocks_ms)


@pytest.mark.parametrize(("effort", "answer"), [(IN_FLIGHT, False), (LITTLE, None)])
def test_it_is_searched_for_laps_once(
    searches: list[LapSearch], effort: Effort, answer: bool | None
) -> None:
    """Whether it is proved that there is none, or the search was given up."""
    of = patrol(TOO_SHORT_S)
    search = TimedSearch(BatterySearch(Search(of.actions)))
    assert search.is_solvable(of, effort) is answer
    assert searches
    searches.clear()
    for place in "ABC":
        assert search.is_solvable(seen(of, place, 10_000), effort) is answer
    assert not searches


def test_what_was_given_up_is_searched_with_more_effort(searches: list[LapSearch]) -> None:
    of = patrol(TOO_SHORT_S)
    search = TimedSearch(BatterySearch(Search(of.actions)))
    assert search.is_solvable(of, LITTLE) is None
    assert search.is_solvable(of, IN_FLIGHT) is False
    searches.clear()
    assert search.is_solvable(of, LITTLE) is False
    assert not searches


def test_with_other_costs_it_is_searched_again() -> None:
    of = patrol(TOO_SHORT_S)
    search = TimedSearch(BatterySearch(Search(of.actions)))
    assert search.is_solvable(of, IN_FLIGHT) is False
    shorter = patrol(TOO_SHORT_S, "A", {pair: 0.8 * cost_s for pair, cost_s in LEGS.items()})
    assert search.is_solvable(shorter, IN_FLIGHT) is True


def test_with_other_limits_it_is_searched_again() -> None:
    of = patrol(TOO_SHORT_S)
    search = TimedSearch(BatterySearch(Search(of.actions)))
    assert search.is_solvable(of, IN_FLIGHT) is False
    assert search.is_solvable(patrol(LONG_ENOUGH_S), IN_FLIGHT) is True


def test_what_is_done_once_and_for_all_makes_no_other_component(
    searches: list[LapSearch],
) -> None:
    """A fact that one more line reads, and that holds for good, is in all states or in none."""
    of = patrol(TOO_SHORT_S)
    look = action("look(A)", "at(A)", "seen", cost_s=5.0)
    read = problem("HABC", LEGS, "F seen")
    of = replace(
        of,
        actions=(*of.actions, look),
        conjuncts=(*of.conjuncts, *read.conjuncts),
        automaton_states=(*of.automaton_states, *read.automaton_states),
        clocks_ms=(*of.clocks_ms, None),
    )
    search = TimedSearch(BatterySearch(Search(of.actions)))
    assert search.is_solvable(of, IN_FLIGHT) is False
    searches.clear()
    assert search.is_solvable(patrol(TOO_SHORT_S, "C"), IN_FLIGHT) is False
    assert not searches


def test_a_copy_knows_as_much(searches: list[LapSearch]) -> None:
    of = patrol(TOO_SHORT_S)
    search = TimedSearch(BatterySearch(Search(of.actions)))
    before = search.known.copied()
    assert search.is_solvable(of, IN_FLIGHT) is False
    after = search.known.copied()
    searches.clear()
    search.known = after
    assert search.is_solvable(of, IN_FLIGHT) is False
    assert not searches
    search.known = before
    assert search.is_solvable(of, IN_FLIGHT) is False
    assert searches


@pytest.mark.parametrize("seeds", [range(25), pytest.param(range(25, 60), marks=pytest.mark.long)])
def test_answers_are_those_of_a_search_that_remembers_nothing(seeds: range) -> None:
    for seed in seeds:
        of = timed_problem(seed)
        remembers = TimedSearch(BatterySearch(Search(of.actions)))
        asked = [of, *(moved[0] for turn in range(4) if (moved := later(of, 10 * seed + turn)))]
        for number, each in enumerate(asked):
            alone = TimedSearch(BatterySearch(Search(of.actions))).is_solvable(each, IN_FLIGHT)
            known = remembers.is_solvable(each, IN_FLIGHT)
            assert alone is None or known is alone, (seed, number)
