"""The best lasso: closed forms, brute force, and what the search says of its own answer.

The properties on drawn problems are in tests/properties/test_best_lasso.py.
"""

from __future__ import annotations

import itertools
from dataclasses import replace

import pytest
from drawn import drawn
from hypothesis import given
from hypothesis import strategies as st
from problems import action, asking, find_lasso, histories, names, problem, unit_legs
from synthetic import facts_of

from companion.errors import SearchLimit
from companion.planning.builtin.search import Search
from companion.planning.check import fault
from companion.planning.domain import WAIT, Action
from companion.planning.effort import BEFORE_FLIGHT, IN_FLIGHT
from companion.planning.lasso import Lasso, Problem
from companion.planning.objective import Objective


def test_a_safe_rest_needs_nothing_but_rest() -> None:
    assert names(find_lasso(problem("HA", unit_legs("HA"), "G !at(A)"))) == ([], ["wait"])


def test_a_visit_is_a_prefix_and_then_rest() -> None:
    found = find_lasso(problem("HA", unit_legs("HA"), "F at(A)"))
    assert names(found) == (["move(H, A)"], ["wait"])


def test_equal_laps_fall_to_the_order_of_the_actions() -> None:
    found = find_lasso(problem("HABC", unit_legs("HABC"), "G F at(A) & G F at(B) & G F at(C)"))
    assert names(found) == (
        ["move(H, A)"],
        ["move(A, B)", "move(B, C)", "move(C, A)"],
    )


def test_equal_paths_fall_to_the_order_of_the_actions() -> None:
    found = find_lasso(
        problem("HABC", unit_legs("HABC"), "F (at(C) & X at(H)) | F (at(B) & X at(H))")
    )
    assert names(found) == (["move(H, B)", "move(B, H)"], ["wait"])


LEGS = {pair: 50.0 for pair in itertools.permutations("HAB", 2)}
LEGS |= {("H", "A"): 100.0, ("A", "B"): 1.0, ("B", "A"): 1.0}


def test_the_lap_comes_before_the_prefix() -> None:
    """A loop around near sites that costs more is not taken although its prefix is shorter."""
    found = find_lasso(problem("HAB", LEGS, "G F at(A) & G F at(B)"))
    assert names(found) == (["move(H, B)"], ["move(B, A)", "move(A, B)"])


def test_the_sum_weighs_the_lap_against_the_prefix() -> None:
    """A loop through H costs more but needs no prefix."""
    legs = {("H", "A"): 3.0, ("A", "H"): 3.0, ("H", "B"): 9.0, ("B", "H"): 9.0}
    asked = problem("HAB", legs, "G F (at(A) & X at(H)) | G F at(B)")
    assert names(find_lasso(asked)) == (["move(H, B)"], ["wait"])
    assert names(find_lasso(asked, Objective.SUM)) == ([], ["move(H, A)", "move(A, H)"])


def test_an_impossible_task_has_no_lasso() -> None:
    assert find_lasso(problem("HA", unit_legs("HA"), "G at(H) & F at(A)")) is None
    assert find_lasso(problem("HA", unit_legs("HA"), "false")) is None


def test_next_is_obeyed_exactly() -> None:
    found = find_lasso(problem("HAB", unit_legs("HAB"), "X (at(A) & X (at(B) & X G at(B)))"))
    assert names(found) == (["move(H, A)", "move(A, B)"], ["wait"])


def test_the_history_is_kept() -> None:
    """What was visited before is not visited again; a plan from scratch would."""
    task = "F at(A) & F at(B)"
    asked = problem("HAB", unit_legs("HAB"), task)
    gone = [facts_of("at(H)"), facts_of("at(A)")]
    later = asking(task, asked.actions, gone)
    found = find_lasso(later)
    assert names(found) == (["move(A, B)"], ["wait"])
    assert found is not None and fault(later, found, [gone, gone]) is None


@drawn(40)
@given(data=st.data(), sites=st.integers(2, 4))
def test_patrolling_is_the_shortest_tour(data: st.DataObject, sites: int) -> None:
    places = "HABCD"[: sites + 1]
    pairs = list(itertools.permutations(places, 2))
    legs = {p: float(data.draw(st.integers(1, 30))) for p in pairs}
    task = " & ".join(f"G F at({p})" for p in places[1:])
    asked = problem(places, legs, task)
    found = find_lasso(asked)
    assert found is not None and fault(asked, found, histories(asked)) is None
    closed = _closure(places, legs)
    tours = (
        sum(closed[a, b] for a, b in itertools.pairwise((places[1], *rest, places[1])))
        for rest in itertools.permutations(places[2:])
    )
    assert found.lap_cost_ms == 1000 * min(tours)


def _closure(places: str, legs: dict[tuple[str, str], float]) -> dict[tuple[str, str], float]:
    """Floyd and Warshall: the shortest path between two places, over any others."""
    best = dict(legs)
    for via, a, b in itertools.product(places, repeat=3):
        if a != b and via not in (a, b):
            best[a, b] = min(best[a, b], best[a, via] + best[via, b])
    return best


FORMULAS = [
    "F (at(A) & F at(B))",
    "G F at(A) & G !at(B)",
    "at(H) U at(B)",
    "G (at(A) -> X at(B)) & G F at(A)",
    "F G at(A)",
    "(!at(B)) U at(A) & F at(B)",
    "G F (at(A) & F at(B)) & G (at(B) -> X !at(B))",
    "F at(A) & F at(B) & G F at(H)",
    "(F at(A) | G at(H)) & !(F at(A) & G at(H))",
    "G (at(H) -> F at(A)) W at(B)",
]


@pytest.mark.parametrize("objective", Objective)
@pytest.mark.parametrize("task", FORMULAS)
def test_every_plan_passes_the_independent_check(task: str, objective: Objective) -> None:
    asked = problem("HAB", unit_legs("HAB"), task)
    found = find_lasso(asked, objective)
    assert found is not None
    assert fault(asked, found, histories(asked)) is None


@drawn(25)
@given(data=st.data())
def test_no_lasso_of_few_steps_is_cheaper(data: st.DataObject) -> None:
    """Brute force over all short lassos finds no shorter lap, whatever the automata say."""
    task = data.draw(st.sampled_from(FORMULAS))
    legs = {p: float(data.draw(st.integers(1, 9))) for p in itertools.permutations("HAB", 2)}
    asked = problem("HAB", legs, task)
    found = find_lasso(asked)
    assert found is not None and fault(asked, found, histories(asked)) is None
    for lasso in _short_lassos(asked, steps=5):
        assert lasso.lap_cost_ms >= found.lap_cost_ms


def _short_lassos(asked: Problem, steps: int) -> list[Lasso]:
    lassos = []
    todo: list[tuple[Action, ...]] = [()]
    while todo:
        path = todo.pop()
        facts = [asked.facts]
        for chosen in path:
            facts.append(chosen.apply(facts[-1]))
        for start in range(len(path)):
            lasso = Lasso(path[:start], path[start:])
            if facts[start] == facts[-1] and fault(asked, lasso, histories(asked)) is None:
                lassos.append(lasso)
        if len(path) < steps:
            todo += [(*path, a) for a in asked.actions if a.is_applicable(facts[-1])]
    return lassos


# -- Actions with conditional effects --------------------------------------------------------------


def test_a_conditional_effect_takes_place_only_under_its_condition() -> None:
    """Only one who carries a parcel delivers it by landing at B."""
    land = action("land", "at(B)", "", 1.0, [("parcel", "delivered & !parcel")])
    load = action("load", "at(A)", "parcel", 2.0)
    found = find_lasso(problem("HAB", unit_legs("HAB"), "F delivered", [load, land]))
    assert names(found) == (["move(H, A)", "load", "move(A, B)", "land"], ["wait"])


def test_a_loop_may_toggle_a_fact_twice() -> None:
    toggle = action("toggle", "", "", 2.0, [("lamp", "!lamp"), ("!lamp", "lamp")])
    found = find_lasso(asking("G F lamp & G F !lamp", [toggle, WAIT], [()]))
    assert names(found) == ([], ["toggle", "toggle"])


# -- What is said of the answer --------------------------------------------------------------------


@pytest.mark.parametrize("objective", Objective)
def test_a_solution_names_its_objective_and_proof(objective: Objective) -> None:
    asked = problem("HAB", LEGS, "G F at(A) & G F at(B)")
    (found,) = Search().solutions(asked, objective)
    cost = {Objective.LAP: 2000, Objective.SUM: 52_000, Objective.BOTTLENECK: 2000}[objective]
    assert (found.objective, found.cost_ms, found.bound_ms) == (objective, cost, cost)
    assert found.is_optimal
    assert found.engine == "built-in"


def test_whether_there_is_a_plan_is_asked_for_the_first_one_alone() -> None:
    search = Search()
    assert search.is_solvable(problem("HA", unit_legs("HA"), "F at(A)"))
    assert not search.is_solvable(problem("HA", unit_legs("HA"), "F at(A) & G at(H)"))


def test_whether_there_is_a_plan_may_take_too_long_to_find_out() -> None:
    """At either limit: of the product, and of the searches from one-shot goals."""
    asked = problem("HABCD", unit_legs("HABCD"), "F at(A) & F at(B) & F at(C) & F at(D)")
    for effort in (
        replace(BEFORE_FLIGHT, product_edges=3),
        replace(BEFORE_FLIGHT, dijkstra_steps=3),
    ):
        assert Search().is_solvable(asked, effort) is None
        with pytest.raises(SearchLimit, match=r"given up at its limit of 3 (edges|steps)"):
            list(Search().solutions(asked, effort=effort))
    assert Search().is_solvable(asked)


def test_many_places_to_visit_once_are_planned_in_flight() -> None:
    """The limit counts what searches take: on a dense graph an edge takes very little."""
    places = [f"s{i}" for i in range(120)]
    legs = {(a, b): 2.0 + i % 7 for i, (a, b) in enumerate(itertools.permutations(places, 2))}
    asked = problem(places, legs, " & ".join(f"F at({place})" for place in places))
    first = next(Search(asked.actions).solutions(asked, effort=IN_FLIGHT))
    assert {action.arguments[-1] for action in first.prefix} == {*places[1:]}


def test_a_limit_is_not_taken_for_no_plan() -> None:
    asked = problem("HAB", unit_legs("HAB"), "G F at(A) & G F at(B)")
    with pytest.raises(SearchLimit, match="limit of 3 edges of the product; there may be a plan"):
        list(Search().solutions(asked, effort=replace(BEFORE_FLIGHT, product_edges=3)))
