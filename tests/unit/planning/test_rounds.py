"""Exact rounds are those of brute force: over all orders of the hits, through every node."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from reference_rounds import Marks, best_round, cost_of, shortest, ways_of

from companion.planning.builtin.rounds import Costs, Rounds, work


@st.composite
def cases(draw: st.DrawFn, most: int = 5) -> tuple[Costs, Marks]:
    """Hits on a complete map, and marks that each have a hit; a hit has one or more."""
    hits = draw(st.integers(1, most))
    kinds = draw(st.integers(1, hits))
    legs = draw(st.lists(st.integers(1, 30), min_size=hits**2, max_size=hits**2))
    marks = np.zeros((hits, kinds), np.bool_)
    for hit in range(hits):
        first = hit if hit < kinds else draw(st.integers(0, kinds - 1))
        marks[hit, [first, *draw(st.lists(st.integers(0, kinds - 1), max_size=2))]] = True
    return shortest(100 * np.array(legs, np.int64).reshape(hits, hits)), marks


@settings(max_examples=100)
@given(cases())
def test_the_shortest_round_is_that_of_brute_force(case: tuple[Costs, Marks]) -> None:
    between, marks = case
    rounds = Rounds(between, marks)
    assert rounds.cost_ms == rounds.bound_ms == best_round(between, marks)
    cycle = rounds.cycle()
    assert marks[cycle].any(axis=0).all()
    assert cost_of(between, cycle) == rounds.cost_ms


@settings(max_examples=100)
@given(cases(4))
def test_through_every_hit_as_well(case: tuple[Costs, Marks]) -> None:
    between, marks = case
    rounds = Rounds(between, marks)
    to_hits, from_hits = ways_of(between)
    costs = rounds.through(to_hits, from_hits)
    for node in range(len(between)):
        assert costs[node] == best_round(between, marks, passing=node)
        order = rounds.order(to_hits[:, node], from_hits[:, node])
        assert marks[order].any(axis=0).all()
        assert cost_of(between, [node, *order]) == costs[node]


@settings(max_examples=60)
@given(cases(4), st.integers(0, 3))
def test_through_a_node_that_is_no_hit(case: tuple[Costs, Marks], chosen: int) -> None:
    """One hit is taken for a node without marks, if the others have all marks."""
    between, marks = case
    node = chosen % len(between)
    hits = [hit for hit in range(len(between)) if hit != node]
    if not hits or not marks[hits].any(axis=0).all():
        return
    rounds = Rounds(between[np.ix_(hits, hits)], marks[hits])
    to_hits, from_hits = between[node, hits], between[hits, node]
    (cost,) = rounds.through(to_hits[:, None], from_hits[:, None])
    assert cost == best_round(between, marks & (np.arange(len(between)) != node)[:, None], node)
    order = rounds.order(to_hits, from_hits)
    assert cost_of(between, [node, *(hits[i] for i in order)]) == cost


def test_one_hit_alone_is_a_turn() -> None:
    rounds = Rounds(np.array([[700]]), np.array([[True]]))
    at_it = np.zeros((1, 1), np.int64)
    assert rounds.cost_ms == rounds.through(at_it, at_it)[0] == 700
    assert rounds.cycle() == rounds.order(at_it[:, 0], at_it[:, 0]) == [0]


def test_a_hit_with_all_marks_saves_the_others() -> None:
    between = shortest(np.full((3, 3), 1000))
    between[2, 2] = 1500
    marks = np.array([[True, False], [False, True], [True, True]])
    assert Rounds(between, marks).cycle() == [2]


@pytest.mark.parametrize("sites", [2, 5, 9])
def test_work_counts_the_additions_of_the_tables(sites: int) -> None:
    """For one mark to a hit two tables of 2^(n - 1) sets, in each n^2 additions."""
    assert work(np.eye(sites, dtype=np.bool_)) == 2 * sites**2 * 2 ** (sites - 1)
