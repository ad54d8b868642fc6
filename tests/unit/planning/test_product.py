"""The product is that of Section III-A: the facts move, and the automata read where they get to."""

from __future__ import annotations

import itertools

import pytest
from hypothesis import given
from hypothesis import strategies as st
from synthetic import at_the_start, command, event, mission, planner

from companion.planning import product as module
from companion.planning.lasso import Problem
from companion.planning.product import Product, SearchLimit
from companion.planning.search import find_lasso

FORMULAS = ["F at(A)", "G F at(A) & G F at(B)", "X at(A)", "at(H) U at(B)", "F G at(A)"]


def problem(formula: str) -> Problem:
    return at_the_start(planner(mission(formula)))[0]


Node = tuple[frozenset[str], tuple[int, ...]]


def naive(asked: Problem) -> set[tuple[Node, Node, int, int]]:
    """Every edge (from, to, action, marks) by the definition, with sets in place of bits."""
    automata = [c.automaton for c in asked.conjuncts]
    offsets = list(itertools.accumulate((a.marks for a in automata), initial=0))[:-1]
    edges: set[tuple[Node, Node, int, int]] = set()
    todo: list[Node] = [(asked.facts, zs) for zs in itertools.product(*asked.automaton_states)]
    seen = set(todo)
    while todo:
        facts, states = node = todo.pop()
        applicable = [(i, a) for i, a in enumerate(asked.actions) if a.is_applicable(facts)]
        for number, action in applicable:
            after = action.apply(facts)
            reads = [
                [t for t in a.outgoing[z] if t.label.matches(after)]
                for a, z in zip(automata, states, strict=True)
            ]
            for steps in itertools.product(*reads):
                target = (after, tuple(t.target for t in steps))
                marks = {o + m for t, o in zip(steps, offsets, strict=True) for m in t.marks}
                edges.add((node, target, number, sum(1 << m for m in marks)))
                todo += [target] if target not in seen else []
                seen.add(target)
    return edges


@pytest.mark.parametrize("formula", FORMULAS)
def test_its_edges_are_those_of_the_definition(formula: str) -> None:
    asked = problem(formula)
    product, expected = Product(asked), naive(asked)
    assert sum(map(len, product.edges)) == len(expected)
    found = sorted((e.action, e.marks, e.cost_ms) for edges in product.edges for e in edges)
    assert found == sorted((a, marks, asked.actions[a].cost_ms) for _, _, a, marks in expected)
    nodes = {node for node, _, _, _ in expected} | {target for _, target, _, _ in expected}
    assert len(product.edges) == len(nodes)


def test_the_marks_of_all_automata_are_asked_for() -> None:
    asked = problem("G F at(A) & G F at(B) & G F at(H)")
    product = Product(asked)
    assert product.all_marks == 0b111
    met = {e.marks for edges in product.edges for e in edges}
    assert {0b001, 0b010, 0b100} <= met  # one for each place


def test_edges_follow_the_order_of_the_actions() -> None:
    product = Product(problem("G F at(A) & G F at(B)"))
    for edges in product.edges:
        assert [e.action for e in edges] == sorted(e.action for e in edges)


def test_a_history_that_no_automaton_can_have_leaves_no_root() -> None:
    """When an event has broken the task, nothing can mend it."""
    made = planner(mission("G !found", events=[event("found")]))
    asked = made.problem(frozenset({"at(H)", "found"}), (frozenset(),))
    assert Product(asked).roots == []
    assert find_lasso(asked) is None


def test_the_search_is_given_up_at_its_limit(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "MAX_NODES", 2)
    with pytest.raises(SearchLimit, match="among the first 2 product states"):
        Product(problem("G F at(A) & G F at(B)"))


@given(st.lists(st.sampled_from(["p", "q", "r", "s"]), max_size=4, unique=True))
def test_a_mask_stands_for_exactly_its_facts(names: list[str]) -> None:
    product = Product(problem("F at(A)"))
    each = [product.mask(frozenset({name})) for name in names]
    assert all(mask.bit_count() == 1 for mask in each)
    assert len(set(each)) == len(each)
    assert product.mask(frozenset(names)) == sum(each)


def test_a_forbidden_fact_keeps_an_action_out() -> None:
    careful = command("report", "!low", "reported")
    made = planner(mission("F reported", skills=[careful], events=[event("low")]))
    states = at_the_start(made)[0].automaton_states
    assert find_lasso(made.problem(frozenset({"at(H)"}), states)) is not None
    assert find_lasso(made.problem(frozenset({"at(H)", "low"}), states)) is None
