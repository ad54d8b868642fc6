"""The best lasso: against brute force, the closed form of a tour, and the paper's own mission."""

from __future__ import annotations

import itertools
from dataclasses import replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from companion.ltl.automaton import successors
from companion.ltl.formula import conjuncts
from companion.ltl.parser import parse
from companion.ltl.translate import translate
from companion.mission.model import Fly
from companion.planning.check import fault
from companion.planning.domain import WAIT, Action
from companion.planning.lasso import Conjunct, Lasso, Problem
from companion.planning.search import find_lasso


def move(origin: str, goal: str, cost_s: float) -> Action:
    return Action(
        name=f"move({origin}, {goal})",
        skill="move",
        requires=frozenset({f"at({origin})"}),
        forbids=frozenset(),
        assumes=frozenset(),
        adds=frozenset({f"at({goal})"}),
        deletes=frozenset({f"at({origin})"}),
        cost_ms=round(1000 * cost_s),
        execute=Fly(goal),
        tries=1,
        timeout_s=None,
    )


def problem(
    places: str, cost: dict[tuple[str, str], float], task: str, extra: tuple[Action, ...] = ()
) -> Problem:
    parts = [Conjunct(str(f), f, translate(f)) for f in conjuncts(parse(task))]
    moves = [move(a, b, cost[a, b]) for a, b in itertools.permutations(places, 2)]
    return Problem(
        actions=(*moves, *extra, WAIT),
        conjuncts=tuple(parts),
        facts=frozenset({f"at({places[0]})"}),
        automaton_states=tuple(
            successors(p.automaton, p.automaton.initial, frozenset({f"at({places[0]})"}))
            for p in parts
        ),
    )


def history(asked: Problem) -> list[list[frozenset[str]]]:
    """At the beginning each conjunct has read the present position and nothing else."""
    return [[asked.facts] for _ in asked.conjuncts]


def names(lasso: Lasso | None) -> tuple[list[str], list[str]]:
    assert lasso is not None
    return [a.name for a in lasso.prefix], [a.name for a in lasso.suffix]


def unit_costs(places: str) -> dict[tuple[str, str], float]:
    return {pair: 1.0 for pair in itertools.permutations(places, 2)}


def test_a_safe_rest_needs_nothing_but_rest() -> None:
    assert names(find_lasso(problem("HA", unit_costs("HA"), "G !at(A)"))) == ([], ["wait"])


def test_a_visit_is_a_prefix_and_then_rest() -> None:
    found = find_lasso(problem("HA", unit_costs("HA"), "F at(A)"))
    assert names(found) == (["move(H, A)"], ["wait"])


def test_equal_laps_fall_to_the_order_of_the_actions() -> None:
    found = find_lasso(problem("HABC", unit_costs("HABC"), "G F at(A) & G F at(B) & G F at(C)"))
    assert names(found) == (
        ["move(H, A)"],
        ["move(A, B)", "move(B, C)", "move(C, A)"],
    )


def test_the_lap_comes_before_the_prefix() -> None:
    """A loop around near sites that costs more is not taken although its prefix is shorter."""
    cost = {pair: 50.0 for pair in itertools.permutations("HAB", 2)}
    cost |= {("H", "A"): 100.0, ("A", "B"): 1.0, ("B", "A"): 1.0}
    found = find_lasso(problem("HAB", cost, "G F at(A) & G F at(B)"))
    assert names(found) == (["move(H, B)"], ["move(B, A)", "move(A, B)"])


def test_an_impossible_task_has_no_lasso() -> None:
    assert find_lasso(problem("HA", unit_costs("HA"), "G at(H) & F at(A)")) is None


def test_next_is_obeyed_exactly() -> None:
    found = find_lasso(problem("HAB", unit_costs("HAB"), "X (at(A) & X (at(B) & X G at(B)))"))
    assert names(found) == (["move(H, A)", "move(A, B)"], ["wait"])


def test_the_history_is_kept() -> None:
    """What was visited before is not visited again; a plan from scratch would."""
    asked = problem("HAB", unit_costs("HAB"), "F at(A) & F at(B)")
    gone = [frozenset({"at(H)"}), frozenset({"at(A)"})]
    states = tuple(c.automaton.initial for c in asked.conjuncts)
    for letter in gone:
        states = tuple(
            successors(c.automaton, s, letter) for c, s in zip(asked.conjuncts, states, strict=True)
        )
    later = replace(asked, facts=gone[-1], automaton_states=states)
    found = find_lasso(later)
    assert names(found) == (["move(A, B)"], ["wait"])
    assert found is not None and fault(later, found, [gone, gone]) is None


@settings(max_examples=40, deadline=None)
@given(data=st.data(), sites=st.integers(2, 4))
def test_patrolling_is_the_shortest_tour(data: st.DataObject, sites: int) -> None:
    places = "HABCD"[: sites + 1]
    pairs = list(itertools.permutations(places, 2))
    cost = {p: float(data.draw(st.integers(1, 30))) for p in pairs}
    task = " & ".join(f"G F at({p})" for p in places[1:])
    asked = problem(places, cost, task)
    found = find_lasso(asked)
    assert found is not None and fault(asked, found, history(asked)) is None
    closed = _closure(places, cost)
    tours = (
        sum(closed[a, b] for a, b in itertools.pairwise((places[1], *rest, places[1])))
        for rest in itertools.permutations(places[2:])
    )
    assert found.lap_cost_ms == 1000 * min(tours)


def _closure(places: str, cost: dict[tuple[str, str], float]) -> dict[tuple[str, str], float]:
    """Floyd and Warshall: the shortest way between two places, over any others."""
    best = dict(cost)
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


@pytest.mark.parametrize("task", FORMULAS)
def test_every_plan_passes_the_independent_check(task: str) -> None:
    asked = problem("HAB", unit_costs("HAB"), task)
    found = find_lasso(asked)
    assert found is not None
    assert fault(asked, found, history(asked)) is None


@settings(max_examples=60, deadline=None)
@given(data=st.data())
def test_no_lasso_of_few_steps_is_cheaper(data: st.DataObject) -> None:
    """Brute force over all short lassos finds no shorter lap."""
    task = data.draw(st.sampled_from(FORMULAS))
    cost = {p: float(data.draw(st.integers(1, 9))) for p in itertools.permutations("HAB", 2)}
    asked = problem("HAB", cost, task)
    found = find_lasso(asked)
    assert found is not None and fault(asked, found, history(asked)) is None
    for lasso in _short_lassos(asked, steps=5):
        assert lasso.lap_cost_ms >= found.lap_cost_ms


def _short_lassos(asked: Problem, steps: int) -> list[Lasso]:
    lassos = []
    todo: list[tuple[Action, ...]] = [()]
    while todo:
        path = todo.pop()
        facts = [asked.facts]
        for action in path:
            facts.append(action.apply(facts[-1]))
        for start in range(len(path)):
            lasso = Lasso(path[:start], path[start:])
            if facts[start] == facts[-1] and fault(asked, lasso, history(asked)) is None:
                lassos.append(lasso)
        if len(path) < steps:
            todo += [(*path, a) for a in asked.actions if a.is_applicable(facts[-1])]
    return lassos


def test_the_check_refuses_what_is_wrong() -> None:
    asked = problem("HA", unit_costs("HA"), "G F at(A)")
    go, back = asked.actions[0], asked.actions[1]
    here = history(asked)
    assert "empty" in (fault(asked, Lasso((go,), ()), here) or "")
    assert "cannot be executed" in (fault(asked, Lasso((back,), (WAIT,)), here) or "")
    assert "does not close" in (fault(asked, Lasso((), (go,)), here) or "")
    assert "does not satisfy" in (fault(asked, Lasso((), (WAIT,)), here) or "")
    assert fault(asked, Lasso((), (go, back)), here) is None
