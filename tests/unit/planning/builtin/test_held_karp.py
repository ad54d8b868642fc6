"""Exact tours are those of brute force: over all orders of the targets, through every node."""

from __future__ import annotations

import numpy as np
import pytest
from drawn import drawn
from hypothesis import given
from hypothesis import strategies as st
from reference_tours import best_tour, cost_of, costs_of, shortest

from companion.planning.builtin.costs import Costs, Marks
from companion.planning.builtin.held_karp import HeldKarp, table_additions


@st.composite
def cases(draw: st.DrawFn, most: int = 5) -> tuple[Costs, Marks]:
    """Targets on a complete map, and marks that each have a target; a target has one or more."""
    targets = draw(st.integers(1, most))
    kinds = draw(st.integers(1, targets))
    legs = draw(st.lists(st.integers(1, 30), min_size=targets**2, max_size=targets**2))
    marks = np.zeros((targets, kinds), np.bool_)
    for target in range(targets):
        first = target if target < kinds else draw(st.integers(0, kinds - 1))
        marks[target, [first, *draw(st.lists(st.integers(0, kinds - 1), max_size=2))]] = True
    return shortest(100 * np.array(legs, np.int64).reshape(targets, targets)), marks


@pytest.mark.slow
@drawn(100)
@given(cases())
def test_the_shortest_tour_is_that_of_brute_force(case: tuple[Costs, Marks]) -> None:
    between, marks = case
    tours = HeldKarp(between, marks)
    assert tours.cost_ms == tours.bound_ms == best_tour(between, marks)
    cycle = tours.cycle()
    assert marks[cycle].any(axis=0).all()
    assert cost_of(between, cycle) == tours.cost_ms


@drawn(100)
@given(cases(4))
def test_through_every_target_as_well(case: tuple[Costs, Marks]) -> None:
    between, marks = case
    tours = HeldKarp(between, marks)
    to_targets, from_targets = costs_of(between)
    costs = tours.costs_through(to_targets, from_targets)
    for node in range(len(between)):
        assert costs[node] == best_tour(between, marks, passing=node)
        order = tours.order_after(to_targets[:, node], from_targets[:, node])
        assert marks[order].any(axis=0).all()
        assert cost_of(between, [node, *order]) == costs[node]


@drawn(60)
@given(cases(4), st.integers(0, 3))
def test_through_a_node_that_is_no_target(case: tuple[Costs, Marks], chosen: int) -> None:
    """One target is taken for a node without marks, if the others have all marks."""
    between, marks = case
    node = chosen % len(between)
    targets = [target for target in range(len(between)) if target != node]
    if not targets or not marks[targets].any(axis=0).all():
        return
    tours = HeldKarp(between[np.ix_(targets, targets)], marks[targets])
    to_targets, from_targets = between[node, targets], between[targets, node]
    (cost,) = tours.costs_through(to_targets[:, None], from_targets[:, None])
    assert cost == best_tour(between, marks & (np.arange(len(between)) != node)[:, None], node)
    order = tours.order_after(to_targets, from_targets)
    assert cost_of(between, [node, *(targets[i] for i in order)]) == cost


def test_one_target_alone_is_a_cycle() -> None:
    tours = HeldKarp(np.array([[700]]), np.array([[True]]))
    at_it = np.zeros((1, 1), np.int64)
    assert tours.cost_ms == tours.costs_through(at_it, at_it)[0] == 700
    assert tours.cycle() == tours.order_after(at_it[:, 0], at_it[:, 0]) == [0]


def test_a_target_with_all_marks_saves_the_others() -> None:
    between = shortest(np.full((3, 3), 1000))
    between[2, 2] = 1500
    marks = np.array([[True, False], [False, True], [True, True]])
    assert HeldKarp(between, marks).cycle() == [2]


@pytest.mark.parametrize("sites", [2, 5, 9])
def test_the_additions_of_the_tables_are_counted(sites: int) -> None:
    """For one mark to a target two tables of 2^(n - 1) sets, in each n^2 additions."""
    assert table_additions(np.eye(sites, dtype=np.bool_)) == 2 * sites**2 * 2 ** (sites - 1)
