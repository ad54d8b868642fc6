"""Why there is no plan: a smallest set of conjuncts in conflict, and the belief to blame."""

from __future__ import annotations

import itertools
from dataclasses import replace

import pytest
from synthetic import at_the_start, command, mission, planner

from companion.planning.explain import why_no_plan
from companion.planning.lasso import Problem
from companion.planning.planner import Planner
from companion.planning.search import find_lasso


def why(made: Planner, withdrawn: frozenset[str] = frozenset()) -> str:
    problem, _ = at_the_start(made)
    problem = replace(problem, facts=problem.facts - withdrawn, withdrawn=withdrawn)
    assert find_lasso(problem) is None
    return why_no_plan(problem)


def test_one_conjunct_that_cannot_hold_is_named_with_its_formula() -> None:
    assert why(planner(mission({"go": "F at(A)", "never": "F gone"}))) == (
        "no plan: never cannot hold from here.\n  never: F gone"
    )


def test_conjuncts_that_only_conflict_together_are_named_together() -> None:
    task = {"a": "F at(A)", "near": "G !at(A)", "b": "F at(B)"}
    assert why(planner(mission(task))) == (
        "no plan: a, near cannot hold together from here.\n  a: F at(A)\n  near: G !at(A)"
    )


def test_a_line_with_two_parts_is_named_once() -> None:
    text = why(planner(mission({"line": "F at(A) & G !at(A)"})))
    assert text.startswith("no plan: line cannot hold together from here.")


def test_the_belief_that_would_help_is_named_and_the_other_is_not() -> None:
    made = planner(mission("F done", skills=[command("do", "at(H)", "done")]))
    withdrawn = frozenset({"can_do", "trans_ok(A, B)"})
    assert why(made, withdrawn).splitlines()[2:] == [
        "  withdrawn: can_do, trans_ok(A, B)",
        "  with can_do there would be a plan",
    ]


def test_each_belief_that_would_help_by_itself_is_named() -> None:
    skills = [command("one", "at(H)", "done"), command("two", "at(H)", "done")]
    made = planner(mission("F done", skills=skills))
    text = why(made, frozenset({"can_one", "can_two"}))
    assert text.endswith("  with can_one or can_two there would be a plan")


def test_no_belief_is_blamed_where_it_takes_two() -> None:
    made = planner(mission("F done", skills=[command("do", "at(A)", "done")], places="HA"))
    text = why(made, frozenset({"can_do", "trans_ok(H, A)"}))
    assert text.endswith("  withdrawn: can_do, trans_ok(H, A)")


CONFLICTS = [
    ["F at(A)", "F at(B)", "G !at(B)", "G F at(H)"],
    ["X at(A)", "X at(B)", "F at(H)"],
    ["G (at(A) -> X at(B))", "F at(A)", "G !at(B)", "G !gone"],
    ["F gone", "G !at(B)", "F at(B)"],
]


def only(problem: Problem, names: set[str]) -> Problem:
    kept = [i for i, c in enumerate(problem.conjuncts) if c.name in names]
    return replace(
        problem,
        conjuncts=tuple(problem.conjuncts[i] for i in kept),
        automaton_states=tuple(problem.automaton_states[i] for i in kept),
    )


@pytest.mark.parametrize("formulas", CONFLICTS)
def test_the_named_conjuncts_conflict_and_every_smaller_set_has_a_plan(
    formulas: list[str],
) -> None:
    task = {f"line{i}": formula for i, formula in enumerate(formulas)}
    made = planner(mission(task))
    problem, _ = at_the_start(made)
    first = why(made).splitlines()[0]
    named = {name for name in task if name in first}
    assert find_lasso(only(problem, named)) is None
    for smaller in itertools.combinations(sorted(named), len(named) - 1):
        assert find_lasso(only(problem, set(smaller))) is not None
