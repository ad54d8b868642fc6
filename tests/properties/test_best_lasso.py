"""The built-in search finds the best lasso: held against definitions, tours and closed forms.

The references (`reference_lassos.py`, `reference_search.py`) share no code with the search.
Problems are drawn; where a test measures work it is the median of several searches, held against
a multiple of what is claimed, because machines are noisy. Seconds are those of `yardstick.py`.
"""

from __future__ import annotations

import itertools
import os
import random
import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import TypeVar

import pytest
from checked_solutions import NOTHING_EXACT, solutions
from drawn import drawn
from hypothesis import given, reject
from hypothesis import strategies as st
from problems import action, asking, problem, random_legs
from reference_lassos import TooLarge, best_lap_and_prefix, best_sum
from reference_search import best_sum as best_sum_of_cycles
from synthetic import facts_of

from companion.planning.builtin.search import Search
from companion.planning.check import fault
from companion.planning.domain import WAIT
from companion.planning.effort import Effort
from companion.planning.lasso import Problem
from companion.planning.objective import Objective

HARDLY_ANYTHING = replace(NOTHING_EXACT, dijkstra_steps=1000)
HANGING_S = 600.0  # wall time

ENDING = [
    "F (at(A) & F at(B))",
    "at(H) U at(B)",
    "F G at(A)",
    "(!at(B)) U at(A) & F at(B)",
    "(F at(A) | G at(H)) & !(F at(A) & G at(H))",
    "F G !at(H)",
    "F done & G (done -> X at(H))",
]
RECURRING = [
    "G F at(A) & G !at(B)",
    "G F at(A) & G F at(B)",
    "G (at(A) -> X at(B)) & G F at(A)",
    "G F (at(A) & F at(B)) & G (at(B) -> X !at(B))",
    "F at(A) & F at(B) & G F at(H)",
    "G (at(H) -> F at(A)) W at(B)",
    "G F (at(A) | at(B)) & G F (at(B) | at(H))",
    "G F done & G F at(A)",
    "G (at(A) -> X (!at(A) W at(B))) & G F at(A) & G F at(H)",
    "G F (at(A) & X at(B)) & G F at(H)",
    "G F lamp & G F !lamp & G F at(B)",
    "G (F at(A) | lamp) & G (F at(B) | lamp)",
]
ONE_SHOT = [
    "F at(A) & F at(B) & F lamp & F done",
    "F at(A) & F at(B) & F lamp & F done & G F at(H)",
    "F (at(A) & lamp) & F (at(B) | done) & F !lamp & F done",
]


@st.composite
def problems(draw: st.DrawFn, tasks: list[str], at_most: int = 2) -> Problem:
    """A task or several on a small map, with a lamp that is toggled and work to do and undo."""

    def seconds() -> float:
        return draw(st.integers(2, 30)) / 10

    legs = {pair: seconds() for pair in itertools.permutations("HAB", 2)}
    extra = (
        action("do", "at(B)", "done", seconds()),
        action("undo", "at(H) & done", "!done", seconds()),
        action("toggle", "at(A)", "", seconds(), [("lamp", "!lamp"), ("!lamp", "lamp")]),
    )
    chosen = draw(st.lists(st.sampled_from(tasks), min_size=1, max_size=at_most, unique=True))
    asked = problem("HAB", legs, " & ".join(chosen), extra)
    lost = [each for each in asked.actions if each is not WAIT]  # rest is always possible
    missing = draw(st.lists(st.sampled_from(lost), max_size=2))
    return replace(asked, actions=tuple(a for a in asked.actions if a not in missing))


# -- The best by definition ------------------------------------------------------------------------

T = TypeVar("T")


def by_definition(reference: Callable[..., T], *asked: object) -> T:
    """What a reference says; a task that is too large for it is drawn anew."""
    try:
        return reference(*asked)
    except TooLarge:
        reject()


@drawn(150)
@given(problems(ENDING + RECURRING) | problems(ONE_SHOT, at_most=1))
def test_the_lap_and_then_the_prefix_are_the_shortest(asked: Problem) -> None:
    found = solutions(asked)
    best = by_definition(best_lap_and_prefix, asked)
    assert bool(found) == (best is not None)
    if found:
        lasso = found[-1].lasso
        assert (lasso.lap_cost_ms, lasso.prefix_cost_ms) == best
        assert found[-1].is_optimal


@drawn(100)
@given(problems(ENDING + RECURRING) | problems(ONE_SHOT, at_most=1))
def test_the_sum_of_prefix_and_lap_is_the_least(asked: Problem) -> None:
    found = solutions(asked, Objective.SUM)
    assert (found[-1].cost_ms if found else None) == by_definition(best_sum, asked)
    assert all(solution.is_optimal for solution in found[-1:])


@drawn(60)
@given(problems(ENDING + RECURRING), st.sampled_from([NOTHING_EXACT, HARDLY_ANYTHING]))
def test_what_is_not_exact_still_finds_a_plan_and_never_promises_too_much(
    asked: Problem, effort: Effort
) -> None:
    best = by_definition(best_lap_and_prefix, asked)
    found = solutions(asked, Objective.LAP, effort)
    assert bool(found) == bool(solutions(asked, Objective.SUM, effort)) == (best is not None)
    for solution in found:
        assert best is not None and solution.bound_ms <= best[0] <= solution.cost_ms


@drawn(60)
@given(problems(ONE_SHOT, at_most=1))
def test_one_shot_goals_in_any_order_still_find_a_plan_with_the_shortest_lap(
    asked: Problem,
) -> None:
    best = by_definition(best_lap_and_prefix, asked)
    found = solutions(asked, effort=NOTHING_EXACT)
    assert (found[-1].cost_ms if found else None) == (best and best[0])


def test_the_path_to_a_loop_is_part_of_the_bound_of_a_sum() -> None:
    """No path leads back to the start, and from there it is far to every site."""
    sites = [f"s{i}" for i in range(6)]
    legs = {**random_legs(random.Random(5), sites, is_symmetric=False)}
    legs |= {("far", site): 60.0 for site in sites}
    asked = problem(["far", *sites], legs, " & ".join(f"G F at({site})" for site in sites))
    best = best_sum_of_cycles(asked)  # here every lap is one
    first, last = solutions(asked, Objective.SUM, NOTHING_EXACT)
    assert best is not None and 60_000 <= first.bound_ms < last.bound_ms < best <= last.cost_ms


def test_a_sum_is_not_promised_to_be_the_least_where_only_the_lap_is() -> None:
    """The tour that is known has the shortest lap, with the lamp on; to light it is a detour."""
    legs = dict.fromkeys(itertools.permutations("HAB", 2), 0.2)
    toggle = action("toggle", "at(A)", "", 0.2, [("lamp", "!lamp"), ("!lamp", "lamp")])
    task = "(F at(A) | G at(H)) & !(F at(A) & G at(H)) & G F at(A) & G F at(B)"
    asked = problem("HAB", legs, task, [toggle])
    best = best_sum(asked)
    for solution in solutions(asked, Objective.SUM, NOTHING_EXACT):
        assert best is not None and solution.bound_ms <= best


def test_a_sum_over_many_one_shot_goals_is_not_promised_to_be_the_least() -> None:
    """What a later solution costs shows that the earlier one promised too much."""
    sites = [f"s{i}" for i in range(22)]
    legs = random_legs(random.Random(1), ["H", *sites])
    asked = problem(["H", *sites], legs, " & ".join(f"F at({site})" for site in sites))
    found = solutions(asked, Objective.SUM)
    assert found[0].bound_ms <= found[-1].cost_ms < found[0].cost_ms


# -- The history -----------------------------------------------------------------------------------


@drawn(120)
@given(st.data(), problems(ENDING + RECURRING))
def test_after_any_history_the_whole_word_satisfies_the_task(
    data: st.DataObject, asked: Problem
) -> None:
    """And a plan is found exactly if there is one, and it is the best."""
    letters = [asked.facts]
    for _ in range(data.draw(st.integers(0, 6))):
        able = [a for a in asked.actions if a.is_applicable(letters[-1])]
        if able:
            letters.append(data.draw(st.sampled_from(able)).apply(letters[-1]))
    task = " & ".join(f"({conjunct.formula})" for conjunct in asked.conjuncts)
    later = asking(task, asked.actions, letters)
    best = by_definition(best_lap_and_prefix, later, letters)
    found = list(Search(asked.actions).solutions(later))
    assert bool(found) == (best is not None)
    if found:
        lasso = found[-1].lasso
        assert fault(later, lasso, [letters for _ in later.conjuncts]) is None
        assert (lasso.lap_cost_ms, lasso.prefix_cost_ms) == best


def test_after_a_history_no_step_is_wasted() -> None:
    """At A, which has been read, the lap goes on with B; there is no need to wait and read it."""
    task = "G F (at(A) & X at(B)) & G F at(H)"
    legs = dict.fromkeys(itertools.permutations("HAB", 2), 0.2)
    asked = problem("HAB", legs, task)
    letters = [facts_of("at(H)"), facts_of("at(A)")]
    later = asking(task, asked.actions, letters)
    by_lap = list(Search().solutions(later))[-1]
    by_sum = list(Search().solutions(later, Objective.SUM))[-1]
    assert (by_lap.lasso.lap_cost_ms, by_lap.lasso.prefix_cost_ms) == best_lap_and_prefix(
        later, letters
    )
    assert by_sum.cost_ms == best_sum(later, letters)


# -- Equal questions have equal answers ------------------------------------------------------------

PLANS = """
import random
from problems import problem, random_legs, surveillance
from companion.planning.lasso import Objective
from companion.planning.builtin.search import Search

def plans():
    for sites in (3, 7, 19):
        places = ["H", *(f"s{i}" for i in range(sites))]
        legs = random_legs(random.Random(sites), places)
        yield surveillance(sites, legs)
        if sites < 10:
            legs = dict.fromkeys(legs, 1.0)
            yield surveillance(sites, legs)
            yield problem(places, legs, " & ".join(f"F at({p})" for p in places))

for asked in plans():
    for objective in Objective:
        for solution in Search().solutions(asked, objective):
            print(solution.cost_ms, solution.bound_ms, solution.lasso)
"""


@pytest.mark.long
def test_the_plan_does_not_depend_on_the_order_of_hashes() -> None:
    """Two interpreters whose sets come in different orders, and the same plans from both."""
    folder = Path(__file__).parents[1]
    running = [
        subprocess.Popen(
            [sys.executable, "-c", PLANS],
            env=os.environ | {"PYTHONHASHSEED": seed, "PYTHONPATH": f"{folder}:{folder.parent}"},
            stdout=subprocess.PIPE,
            text=True,
        )
        for seed in ("1", "4242")
    ]
    texts = [process.communicate(timeout=HANGING_S)[0] for process in running]
    assert [process.returncode for process in running] == [0, 0]
    assert texts[0].count("w\n") > 15
    assert texts[0] == texts[1]


@given(problems(ENDING + RECURRING + ONE_SHOT))
def test_a_search_that_has_planned_before_plans_the_same(asked: Problem) -> None:
    search = Search(asked.actions)
    first = list(search.solutions(asked))
    list(search.solutions(replace(asked, facts=facts_of("at(B)", "lamp"))))
    assert list(search.solutions(asked)) == first
