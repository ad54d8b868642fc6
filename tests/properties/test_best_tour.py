"""The best lap by the bottleneck, and the best tours, against enumeration."""

from __future__ import annotations

import itertools
import random
import statistics
from collections.abc import Iterator
from dataclasses import replace
from functools import cache

import pytest
from checked_solutions import NOTHING_EXACT, solutions
from drawn import drawn, number
from hypothesis import given
from hypothesis import strategies as st
from problems import action, histories, problem, random_legs, surveillance
from reference_search import best_bottleneck, shortest_tour
from yardstick import Stopwatch

from companion.planning.builtin.search import Search
from companion.planning.check import fault
from companion.planning.lasso import Problem, Solution, word
from companion.planning.objective import Objective

# -- The bottleneck -------------------------------------------------------------------------------

BOTTLENECKS = {
    "G F at(A) & G F at(B)": ["at(A)", "at(B)"],
    "G F at(A) & G F at(B) & G F at(H)": ["at(A)", "at(B)", "at(H)"],
    "G F lamp & G F at(B)": ["lamp", "at(B)"],
}


def bottleneck_ms(asked: Problem, solution: Solution, facts: list[str]) -> int:
    """The longest time between two positions with the same one of some facts, for ever."""
    _, letters = word(asked, solution.lasso)
    costs = [step.cost_ms for step in solution.lasso.loop]
    longest = 0
    for fact in facts:
        since = 0
        for letter, cost in [
            *zip(letters, costs, strict=True)
        ] * 2:  # twice through passes the seam
            since += cost
            longest = max(longest, since)
            since = 0 if fact in letter else since
    return longest


@drawn(40)
@given(st.data(), st.sampled_from(sorted(BOTTLENECKS)))
def test_the_bottleneck_is_what_the_plan_has_and_within_its_bound(
    data: st.DataObject, task: str
) -> None:
    legs = {p: data.draw(st.integers(1, 6)) * 0.5 for p in itertools.permutations("HAB", 2)}
    toggle = action("toggle", "at(H)", "", 1.0, [("lamp", "!lamp"), ("!lamp", "lamp")])
    asked = problem("HAB", legs, task, [toggle])
    asked = replace(asked, actions=asked.actions[:-1])  # resting would need a finer unit
    best = best_bottleneck(asked, 500)
    found = solutions(asked, Objective.BOTTLENECK)
    assert best is not None and found
    for solution in found:
        assert solution.cost_ms == bottleneck_ms(asked, solution, BOTTLENECKS[task])
        assert solution.bound_ms <= best <= solution.cost_ms


def test_of_equal_laps_the_one_with_the_smaller_bottleneck_is_told_from_the_other() -> None:
    """A, C, B takes as long as B, D, but there both parts are met twice a lap."""
    legs = {("A", "C"): 0.5, ("C", "B"): 0.5, ("B", "A"): 0.5}
    legs |= {("H", "D"): 0.5, ("D", "B"): 1.0, ("B", "D"): 0.5}
    asked = problem("HABCD", legs, "G F (at(A) | at(B)) & G F (at(B) | at(C))")
    asked = replace(asked, actions=asked.actions[:-1])
    solution = solutions(asked, Objective.BOTTLENECK)[-1]
    _, letters = word(asked, solution.lasso)
    meetings = sum(not letter.isdisjoint({"at(A)", "at(B)"}) for letter in letters)
    assert solution.cost_ms == (1000 if meetings == 2 else 1500)


def test_on_a_patrol_the_bottleneck_is_the_lap() -> None:
    asked = surveillance(6, random_legs(random.Random(6), ["H", *(f"s{i}" for i in range(6))]))
    (solution,) = solutions(asked, Objective.BOTTLENECK)
    assert solution.is_optimal
    assert solution.cost_ms == solutions(asked)[-1].cost_ms


# -- Tours -----------------------------------------------------------------------------------------


@cache
def a_map(sites: int, seed: int) -> tuple[Problem, int]:
    """A surveillance mission on a random map, every second one with wind; its shortest lap."""
    places = [f"s{i}" for i in range(sites)]
    legs = random_legs(random.Random(seed), ["H", *places], is_symmetric=seed % 2 == 0)
    asked = surveillance(sites, legs)
    costs = {a: b.cost_ms for b in asked.actions for a in _flights(b.name)}
    return asked, shortest_tour(places, costs)


def _flights(name: str) -> Iterator[tuple[str, str]]:
    if name.startswith("move"):
        origin, goal = name[5:-1].split(", ")
        yield origin, goal


def seconds_and_solutions(asked: Problem) -> tuple[list[float], list[Solution]]:
    """When each solution was there, counted from the question, and the solutions."""
    search = Search(asked.actions)
    found, times = [], []
    watch = Stopwatch()
    for solution in search.solutions(asked):
        times.append(watch.seconds())
        found.append(solution)
    return times, found


def test_laps_over_up_to_10_sites_are_the_shortest_on_many_maps() -> None:
    taken_s, maps = [], number(100)
    for seed in range(maps):
        asked, best_ms = a_map(2 + seed % 9, seed)
        times, found = seconds_and_solutions(asked)
        taken_s += times[-1:] if seed % 9 == 8 else []  # with 10 sites
        assert found[-1].lasso.lap_cost_ms == best_ms
        assert found[-1].is_optimal
        assert fault(asked, found[-1].lasso, histories(asked)) is None
    assert len(taken_s) == maps // 9
    assert statistics.median(taken_s) < 3 * 0.1


@pytest.mark.long
def test_laps_over_17_sites_are_the_shortest() -> None:
    taken_s = []
    for seed in range(1, 2):
        asked, best_ms = a_map(17, seed)
        times, found = seconds_and_solutions(asked)
        taken_s.append(times[-1])
        assert found[-1].lasso.lap_cost_ms == best_ms
        assert found[-1].is_optimal
    assert statistics.median(taken_s) < 3 * 0.5


@pytest.mark.long
def test_over_50_sites_a_plan_comes_at_once_and_a_good_one_soon() -> None:
    first_s, last_s = [], []
    for seed in range(0, 4, 2):
        places = ["H", *(f"s{i}" for i in range(50))]
        asked = surveillance(50, random_legs(random.Random(seed), places))
        times, found = seconds_and_solutions(asked)
        first_s.append(times[0])
        last_s.append(times[-1])
        assert found[-1].cost_ms <= found[0].cost_ms
        assert 0 < found[-1].bound_ms <= found[-1].cost_ms <= 1.05 * found[-1].bound_ms
        assert fault(asked, found[-1].lasso, histories(asked)) is None
    assert statistics.median(first_s) < 4 * 0.05
    assert statistics.median(last_s) < 3 * 1.0


@pytest.mark.parametrize(
    "seed", [*range(6), *(pytest.param(n, marks=pytest.mark.long) for n in range(6, 20))]
)
def test_a_tour_that_is_not_exact_lies_between_its_bound_and_little_above_the_best(
    seed: int,
) -> None:
    asked, best_ms = a_map(4 + seed % 6, seed)
    first, last = solutions(asked, effort=NOTHING_EXACT)
    assert first.bound_ms <= last.bound_ms <= best_ms <= last.cost_ms <= first.cost_ms
    assert last.cost_ms <= 1.03 * best_ms


def test_a_tour_takes_paths_over_other_places() -> None:
    """No direct way leads from one site to another: every lap passes the middle again and again."""
    sites = [f"s{i}" for i in range(6)]
    legs = {pair: 1.0 + i for i, site in enumerate(sites) for pair in (("H", site), (site, "H"))}
    (solution,) = solutions(surveillance(6, legs))
    assert solution.cost_ms == 2000 * sum(range(1, 7))
    assert solution.is_optimal
