"""The independent check of bounds finds what is late, wherever that is."""

from __future__ import annotations

from dataclasses import replace

from problems import problem, unit_legs
from timed_problems import with_bounds

from companion.ltl.parser import parse
from companion.ltl.time_bounds import Response, Revisit, TimeBound, Within
from companion.mission.facts import Fact
from companion.planning.domain import WAIT, Action
from companion.planning.lasso import Lasso, Problem
from companion.planning.time_check import longest_waits, time_fault

HERE = frozenset({Fact.parse("at(H)")})


def asked(bound: TimeBound, elapsed_ms: int | None = None) -> Problem:
    """Places a second from each other, and one bound."""
    plain = problem("HAB", unit_legs("HAB"), "G F at(A)")
    found = with_bounds(plain, {"line": bound}, HERE)
    return replace(found, clocks_ms=(None, elapsed_ms)) if elapsed_ms is not None else found


def flown(of: Problem, prefix: str, loop: str) -> Lasso:
    """A plan by the places that it flies to; `-` is a step of rest."""
    by_name = {action.name: action for action in of.actions}
    here, parts = "H", []
    for places in (prefix, loop):
        part: list[Action] = []
        for place in places:
            part.append(WAIT if place == "-" else by_name[f"move({here}, {place})"])
            here = here if place == "-" else place
        parts.append(tuple(part))
    return Lasso(*parts)


def test_a_revisit_counts_the_leg_that_leaves() -> None:
    of = asked(Revisit(parse("at(A)"), 2000))
    assert time_fault(of, flown(of, "A", "BA")) is None
    wrong = time_fault(of, flown(of, "A", "BHA"))
    assert wrong == "line: revisit(A) <= 2 s is late by 1 s after move(H, A)"


def test_what_is_late_between_two_laps_is_found() -> None:
    """Each half is short enough; from the last visit of a lap to the first of the next is not."""
    of = asked(Revisit(parse("at(A)"), 3000))
    assert time_fault(of, flown(of, "B", "HABH")) == (
        "line: revisit(A) <= 3 s is late by 1 s after move(H, A)"
    )


def test_the_present_clock_counts() -> None:
    bound = Within(parse("at(B)"), 3000)
    of = asked(bound, 1000)
    assert time_fault(of, flown(of, "AB", "AB")) is None
    of = asked(bound, 1500)
    assert (
        time_fault(of, flown(of, "AB", "AB"))
        == "line: F[<=3s] at(B) is late by 0.5 s after move(A, B)"
    )


def test_rest_takes_longer_than_it_costs() -> None:
    of = asked(Revisit(parse("at(A)"), 2500))
    assert time_fault(of, flown(of, "A", "-")) is None
    assert time_fault(of, flown(of, "A", "B-A")) is not None


def test_a_rest_with_a_clock_that_runs_is_late_in_the_end() -> None:
    of = asked(Response(parse("at(B)"), 60_000, parse("at(A)")))
    assert (
        time_fault(of, flown(of, "A", "-"))
        == "line: G(at(A) -> F[<=60s] at(B)) is late by 1 s after wait"
    )
    assert time_fault(of, flown(of, "AB", "-")) is None


def test_what_rose_and_fell_asks_for_an_answer() -> None:
    of = replace(
        asked(Response(parse("at(B)"), 2000, parse("alarm"))),
        unread=frozenset({Fact.parse("alarm")}),
    )
    assert time_fault(of, flown(of, "AB", "A-")) is None
    assert time_fault(of, flown(of, "AHAB", "A-")) is not None


def test_the_longest_wait_is_told_with_its_places() -> None:
    of = asked(Revisit(parse("at(A)"), 5000))
    (wait,) = longest_waits(of, flown(of, "BA", "BABHA"))
    assert (wait.elapsed_ms, wait.slack_ms, wait.places) == (3000, 2000, ("A", "B", "H", "A"))
