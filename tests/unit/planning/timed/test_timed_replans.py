"""Plans made anew with clocks that run, laps that are kept, and what is told without a plan."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import pytest
from problems import action, histories, names, problem
from timed_problems import with_bounds

from companion.errors import SearchLimit
from companion.ltl.parser import parse
from companion.ltl.time_bounds import Response, Revisit, TimeBound, Within
from companion.mission.facts import Fact, at
from companion.planning.builtin.search import Search
from companion.planning.check import fault
from companion.planning.effort import BEFORE_FLIGHT, IN_FLIGHT
from companion.planning.energy.search import BatterySearch
from companion.planning.lasso import Problem, Solution
from companion.planning.time_check import time_fault
from companion.planning.timed import lassos
from companion.planning.timed.lap_search import LapSearch
from companion.planning.timed.lateness import late_bounds
from companion.planning.timed.search import TimedSearch

LINE = {"H": 0.0, "A": 10.0, "B": 30.0, "C": 60.0}
"""Places along a line, by the second."""
LEGS = {(a, b): abs(LINE[a] - LINE[b]) for a in LINE for b in LINE if a != b}


def asked(bounds: Mapping[str, TimeBound], task: str = "patrolling(A, B, C)") -> Problem:
    """A patrol along the line, from H."""
    return with_bounds(problem("HABC", LEGS, task), dict(bounds), frozenset({at("H")}))


def often(place: str, seconds: float) -> dict[str, TimeBound]:
    """A place is visited again and again."""
    return {"often": Revisit(parse(f"at({place})"), round(1000 * seconds))}


def moved(of: Problem, place: str, clocks_ms: tuple[int | None, ...]) -> Problem:
    """The same at another place, with other clocks."""
    unbounded = len(of.conjuncts) - len(clocks_ms)
    facts = frozenset(fact for fact in of.facts if fact.predicate != "at") | {at(place)}
    return replace(of, facts=facts, clocks_ms=(*[None] * unbounded, *clocks_ms))


def best(search: TimedSearch, of: Problem) -> Solution | None:
    """The last plan of a search, which is right."""
    found = list(search.solutions(of, BEFORE_FLIGHT))
    for solution in found:
        assert fault(of, solution.lasso, histories(of)) is None
        assert time_fault(of, solution.lasso) is None
    return found[-1] if found else None


def test_a_lap_visits_a_place_twice_where_one_visit_is_too_seldom() -> None:
    search = TimedSearch(BatterySearch(Search()))
    tour, twice = best(search, asked(often("B", 110))), best(search, asked(often("B", 70)))
    assert tour is not None and twice is not None
    assert (tour.lasso.lap_cost_ms, twice.lasso.lap_cost_ms) == (100_000, 100_000)
    assert [a.name for a in twice.loop].count("move(A, B)") == 1
    assert {"move(A, B)", "move(C, B)"} <= {a.name for a in twice.loop}


def test_what_no_line_asks_for_is_not_done_on_the_way() -> None:
    """What is done once splits the product into parts, which have the same laps."""
    works = [action(f"work({p})", f"at({p})", f"done({p})", cost_s=5.0) for p in "HABC"]
    of = asked(often("A", 110))
    of = replace(of, actions=(*of.actions, *works))
    search = TimedSearch(BatterySearch(Search(of.actions)))
    first = best(search, of)
    assert first is not None
    assert not any(each.skill == "work" for each in first.lasso.prefix)
    again = best(search, moved(of, "C", (40_000,)))
    assert again is not None
    assert not any(each.skill == "work" for each in again.lasso.prefix)


def test_a_plan_made_anew_keeps_the_lap() -> None:
    of = asked(often("A", 110))
    search = TimedSearch(BatterySearch(Search(of.actions)))
    first = best(search, of)
    assert first is not None
    later = moved(of, "C", (40_000,))
    again = next(search.solutions(later, IN_FLIGHT))
    assert sorted(a.name for a in again.loop) == sorted(a.name for a in first.loop)


def test_the_clock_decides_which_way_a_lap_is_entered() -> None:
    of = asked(often("A", 120))
    search = TimedSearch(BatterySearch(Search(of.actions)))
    fresh, late = (best(search, moved(of, "B", (clock,))) for clock in (0, 70_000))
    assert fresh is not None and late is not None
    assert names(late.lasso)[0] + names(late.lasso)[1][:1] == ["move(B, A)"]
    assert late.lasso.lap_cost_ms == fresh.lasso.lap_cost_ms


def test_what_is_late_uses_up_what_plans_keep_in_hand() -> None:
    of = asked({"soon": Within(parse("at(C)"), 100_000)})
    search = TimedSearch(BatterySearch(Search(of.actions)))
    assert of.conjuncts[-1].bound is not None and of.conjuncts[-1].bound.planned_ms == 95_000
    for clock, is_kept in ((35_000, True), (38_000, True), (40_000, True), (40_001, False)):
        assert (best(search, moved(of, "H", (clock,))) is not None) == is_kept


def test_what_rose_and_fell_is_answered() -> None:
    of = asked({"answer": Response(parse("at(C)"), 70_000, parse("alarm"))})
    search = TimedSearch(BatterySearch(Search(of.actions)))
    calm = best(search, of)
    risen = replace(of, unread=frozenset({Fact.parse("alarm")}))
    rushed = best(search, risen)
    assert calm is not None and rushed is not None
    reached_s = 0.0
    for each in (*rushed.prefix, *rushed.loop):
        reached_s += each.cost_ms / 1000
        if each.destination == "C":
            break
    assert reached_s <= 66.5 + LEGS["H", "A"]  # the first letter is that of the first place


@pytest.mark.parametrize(("seconds", "is_kept"), [(110, True), (90, False)])
def test_a_goal_that_an_event_met_is_due_again_after_the_next_position(
    seconds: int, is_kept: bool
) -> None:
    """The event has come and gone: its clock stands still until the next letter, which has it."""
    called = Revisit(parse("at(A) | called"), 1000 * seconds)
    of = moved(asked({"often": called}), "C", (None,))
    of = replace(of, unread=frozenset({Fact.parse("called")}))
    search = TimedSearch(BatterySearch(Search(of.actions)))
    assert (best(search, of) is not None) == is_kept
    assert search.is_solvable(of, IN_FLIGHT) is is_kept


def test_it_is_told_how_far_a_bound_would_have_to_be_relaxed() -> None:
    of = asked(often("A", 60))
    search = TimedSearch(BatterySearch(Search(of.actions)))
    assert best(search, of) is None
    (line,) = late_bounds(search, of, BEFORE_FLIGHT)
    assert line == (
        "revisit(A) <= 60 s cannot be kept: A, C, B, A takes 100 s, 43 s more than is planned "
        "for; from 105.3 s on it can be"
    )
    relaxed = asked(often("A", 105.3))
    assert best(search, relaxed) is not None
    assert best(search, asked(often("A", 105.2))) is None


def test_a_search_that_ends_too_early_does_not_say_that_there_is_no_plan() -> None:
    of = asked(often("A", 110) | {"other": Revisit(parse("at(B)"), 90_000)})
    search = TimedSearch(BatterySearch(Search(of.actions)))
    with pytest.raises(SearchLimit, match="no proof"):
        list(search.solutions(of, replace(BEFORE_FLIGHT, time_labels=10)))
    assert search.is_solvable(of, replace(BEFORE_FLIGHT, time_labels=10)) is None
    assert late_bounds(search, of, replace(BEFORE_FLIGHT, time_labels=10)) == ()
    assert search.is_solvable(of, BEFORE_FLIGHT) is True


def test_laps_to_which_nothing_leads_in_time_are_not_searched(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Of A and C, whichever comes second is too late. The patrol has laps for all that."""
    bounds: dict[str, TimeBound] = {
        "west": Within(parse("done(A)"), 60_000),
        "east": Within(parse("done(C)"), 60_000),
        "often": Revisit(parse("at(B)"), 90_000),
    }
    works = [action(f"work({p})", f"at({p})", f"done({p})", cost_s=1.0) for p in "AC"]
    of = asked(bounds)
    of = replace(of, actions=(*of.actions, *works))
    search = TimedSearch(BatterySearch(Search(of.actions)))
    searched = []

    def noted(*given: Any, **more: Any) -> LapSearch:
        searched.append(given)
        return LapSearch(*given, **more)

    monkeypatch.setattr(lassos, "LapSearch", noted)
    assert search.is_solvable(moved(of, "B", (35_000, 25_000, 0)), IN_FLIGHT) is False
    assert not searched
