"""The product is that of Section III-A: the facts move, and the automata read where they get to."""

from __future__ import annotations

import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
import reference_search as reference
from problems import action, asking, find_lasso, problem, unit_legs
from synthetic import command, event, facts_of, mission, planner

from companion.errors import SearchLimit
from companion.planning.builtin.masked_actions import KnownActions
from companion.planning.builtin.product import MIN_ONE_SHOT_GOALS, Product
from companion.planning.builtin.restrictions import Restrictions
from companion.planning.domain import WAIT
from companion.planning.lasso import Problem

FORMULAS = ["F at(A)", "G F at(A) & G F at(B)", "X at(A)", "at(H) U at(B)", "F G at(A)"]
AT_H = facts_of("at(H)")


def on_the_map(task: str) -> Problem:
    return problem("HAB", unit_legs("HAB"), task)


def product(asked: Problem, max_edges: int = 100_000) -> Product:
    return Product(asked, KnownActions(asked.actions), Restrictions(), max_edges)


@pytest.mark.parametrize("formula", FORMULAS)
def test_its_edges_are_those_of_the_definition(formula: str) -> None:
    """Nothing is constant here. A node here also says what was met on the way into it."""
    asked = on_the_map(formula)
    made, expected = product(asked), reference.edges(asked)
    assert len(set(made.state_of)) == len(expected)
    entered = {
        (target, marks) for leaving in expected.values() for target, _, _, marks in leaving
    } | {(node, 0) for node in reference.initial(asked)}
    assert made.nodes == len(entered)
    found = sorted(
        (action, cost, made.marks[target])
        for node in set(made.state_of)
        for action, cost, target in made.edges(node)
    )
    assert found == sorted(
        (action, cost, marks) for leaving in expected.values() for _, action, cost, marks in leaving
    )


def test_nodes_of_one_product_state_differ_in_their_marks_alone() -> None:
    made = product(on_the_map("G F at(A) & G F at(B)"))
    for node, first in enumerate(made.state_of):
        assert made.state_of[first] == first <= node
        assert list(made.edges(node)) == list(made.edges(first))
        assert node == first or made.marks[node] != made.marks[first]


def test_the_marks_of_all_automata_are_asked_for() -> None:
    made = product(on_the_map("G F at(A) & G F at(B) & G F at(H)"))
    assert made.all_marks == 0b111
    assert {0b001, 0b010, 0b100} <= set(made.marks)  # one for each place


def test_edges_follow_the_order_of_the_actions_and_fit_the_matrix() -> None:
    made = product(on_the_map("G F at(A) & G F at(B)"))
    matrix = made.cost_matrix().toarray()
    assert np.count_nonzero(matrix) == len(made.ends)
    for node in range(made.nodes):
        edges = list(made.edges(node))
        assert [action for action, _, _ in edges] == sorted(action for action, _, _ in edges)
        assert all(matrix[node, target] == cost for _, cost, target in edges)


def test_of_equal_effects_the_cheapest_action_is_kept_and_of_equal_costs_the_first() -> None:
    several = [action(f"do{i}", "", "done", cost_s) for i, cost_s in enumerate([3, 1, 2, 1])]
    made = product(asking("F done", several, [()]))
    assert {action for action, _, _ in made.edges(made.initial[0])} == {1}


# -- As a graph ------------------------------------------------------------------------------------


@pytest.mark.parametrize("formula", FORMULAS)
def test_its_graph_has_the_same_nodes_and_edges_in_words(formula: str) -> None:
    asked = on_the_map(formula)
    made = product(asked)
    graph = made.to_networkx()
    assert list(graph) == list(range(made.nodes))
    assert graph.graph["initial"] == tuple(made.initial)
    assert sum(1 << mark for mark in range(graph.graph["marks"])) == made.all_marks
    assert graph.graph["conjuncts"] == tuple(str(c.formula) for c in asked.conjuncts)
    for node, data in graph.nodes(data=True):
        assert sum(1 << mark for mark in data["marks"]) == made.marks[node]
        assert len(data["automaton_states"]) == len(asked.conjuncts)
        for _, target, edge in graph.out_edges(node, data=True):
            (action,) = [a for a in asked.actions if a.name == edge["action"]]
            assert action.is_applicable(data["facts"])
            assert action.apply(data["facts"]) == graph.nodes[target]["facts"]
            assert edge["cost_ms"] == action.cost_ms
        assert len(graph.out_edges(node)) == len(list(made.edges(node)))
    states = {(d["facts"], d["automaton_states"]) for _, d in graph.nodes(data=True)}
    assert len(states) == len(set(made.state_of))


def test_its_graph_tells_constants_and_goals_that_are_kept_out() -> None:
    places = "HABCD"
    task = " & ".join(f"F at({p})" for p in places[1:])
    asked = problem(places, unit_legs(places), f"{task} & G !found")
    made = product(replace(asked, facts=asked.facts | facts_of("day")))
    graph = made.to_networkx()
    assert graph.graph["constant"] == {"day"}
    assert graph.graph["conjuncts"] == ()
    assert graph.graph["one_shot_goals"] == 4
    met = {next(iter(d["facts"])): d["goals"] for _, d in graph.nodes(data=True)}
    assert met == {f"at({p})": (i,) if i >= 0 else () for i, p in enumerate(places, start=-1)}


@pytest.mark.long
def test_networkx_is_loaded_for_graphs_alone() -> None:
    code = "import sys, companion.planning.builtin.search; print('networkx' in sys.modules)"
    ended = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert ended.stdout.strip() == "False"


# -- What is left out ------------------------------------------------------------------------------


def test_constants_are_taken_out_of_the_automata() -> None:
    """Before a target is found the paper's mission is a patrol, afterwards it is not."""
    task = "G (F at(A) | found) & G (F at(B) | found) & G (found -> F at(H))"
    patrol = product(on_the_map("G F at(A) & G F at(B)"))
    before = product(on_the_map(task))
    assert (before.nodes, before.all_marks) == (patrol.nodes, patrol.all_marks)
    asked = on_the_map(task)
    after = product(asking(task, asked.actions, [AT_H | {"found"}]))
    assert after.all_marks == 0b1
    assert len(set(after.state_of)) == 3  # the places


@pytest.mark.parametrize("count", [MIN_ONE_SHOT_GOALS - 1, MIN_ONE_SHOT_GOALS])
def test_many_one_shot_goals_are_kept_out_of_the_product_and_few_are_not(count: int) -> None:
    places = "HABCDE"[: count + 1]
    task = " & ".join(f"F at({place})" for place in places[1:])
    made = product(problem(places, unit_legs(places), task))
    if count < MIN_ONE_SHOT_GOALS:
        assert made.one_shot_goals == []
        assert len(set(made.state_of)) > 2**count
    else:
        assert len(made.one_shot_goals) == count
        assert made.nodes == len(places)
        assert made.all_marks == 0


def test_a_one_shot_goal_is_met_where_its_letter_is_read() -> None:
    places = "HABCD"
    asked = problem(places, unit_legs(places), " & ".join(f"F at({p})" for p in places[1:]))
    made = product(asked)
    entered = {asked.actions[a].name: node for n in range(5) for a, _, node in made.edges(n)}
    assert made.one_shot_goals == [[entered[f"move(H, {place})"]] for place in places[1:]]


def test_a_one_shot_goal_that_is_met_is_not_asked_for_again() -> None:
    places = "HABCD"
    task = " & ".join(f"F at({place})" for place in places[1:])
    asked = problem(places, unit_legs(places), task)
    later = asking(task, asked.actions, [AT_H, {"at(B)"}, {"at(A)"}])
    assert product(later).one_shot_goals == []  # two are left, which are few
    assert len(set(product(later).state_of)) > len(places)


# -- Ends ------------------------------------------------------------------------------------------


def test_a_history_that_no_automaton_can_have_leaves_no_initial_node() -> None:
    """When an event has broken the task, nothing can mend it."""
    made = planner(mission("G !found", events=[event("found")]))
    asked = made.problem(facts_of("at(H)", "found"), (frozenset(),))
    assert product(asked).initial == []
    assert find_lasso(asked) is None


def test_an_automaton_that_accepts_nothing_under_the_constants_leaves_no_initial_node() -> None:
    asked = on_the_map("F gone & G F at(A)")
    assert product(asked).nodes == 0
    assert find_lasso(asked) is None


def test_without_actions_there_is_no_infinite_word() -> None:
    asked = asking("G !gone", [], [AT_H])
    assert product(asked).nodes == 1
    assert len(product(asked).ends) == 0
    assert find_lasso(asked) is None


def test_without_a_task_every_run_will_do() -> None:
    asked = replace(asking("true", [WAIT], [AT_H]), conjuncts=(), automaton_states=())
    assert product(asked).nodes == 1
    assert str(find_lasso(asked)) == "(wait)^w"


def test_the_search_is_given_up_at_its_limit() -> None:
    asked = on_the_map("G F at(A) & G F at(B)")
    edges = len(product(asked).ends)
    assert product(asked, edges).nodes
    with pytest.raises(SearchLimit, match=f"limit of {edges - 1} edges of the product"):
        product(asked, edges - 1)


def test_too_many_initial_states_are_not_even_listed() -> None:
    """Each conjunct may be in two states after its history: there are 2^60 initial states."""
    task = " & ".join(f"F G (at(A) & x{i} | at(B) & !x{i})" for i in range(60))
    toggles = [action(f"toggle{i}", "", "", 1.0, [(f"x{i}", f"!x{i}")]) for i in range(60)]
    toggles += [action(f"set{i}", "", f"x{i}") for i in range(60)]
    asked = on_the_map(task)
    later = asking(task, [*asked.actions, *toggles], [AT_H, {"at(B)"}])
    assert all(len(states) == 2 for states in later.automaton_states)
    with pytest.raises(SearchLimit, match="limit of 100,000 initial states"):
        product(later)


def test_a_forbidden_fact_keeps_an_action_out() -> None:
    careful = command("report", "!low", "reported")
    made = planner(mission("F reported", skills=[careful], events=[event("low")]))
    (conjunct,) = made.conjuncts
    states = (conjunct.automaton.initial,)
    assert find_lasso(made.problem(AT_H, states)) is not None
    assert find_lasso(made.problem(AT_H | facts_of("low"), states)) is None


def test_automata_are_cut_down_once_for_the_same_constants() -> None:
    asked = on_the_map("G (F at(A) | found)")
    (conjunct,) = asked.conjuncts
    kept = Restrictions()
    before = kept.of(conjunct, {"at(A)": None, "found": False}.__getitem__)
    after = kept.of(conjunct, {"at(A)": None, "found": True}.__getitem__)
    assert kept.of(conjunct, {"at(A)": None, "found": False}.__getitem__) is before is not after
