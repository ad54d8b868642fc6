"""A tour of local search is never better than the best and never worse than its bound says."""

from __future__ import annotations

import numpy as np
import pytest
from reference_tours import cost_of, costs_of, shortest

from companion.planning.builtin.costs import Costs, Marks
from companion.planning.builtin.held_karp import HeldKarp
from companion.planning.builtin.local_search import LocalSearch

SEEDS = [0, *(pytest.param(seed, marks=pytest.mark.long) for seed in range(1, 8))]
KINDS = ("symmetric", "with wind", "several marks to a target")


def case(kind: str, seed: int, targets: int | None = None) -> tuple[Costs, Marks]:
    """Targets on a random map, costs in tenths of a second."""
    chance = np.random.default_rng(seed)
    size = targets or int(chance.integers(4, 12))
    where = chance.uniform(0, 50, (size, 2))
    legs = np.hypot(*(where[:, None] - where).transpose(2, 0, 1))
    if kind == "with wind":
        legs = legs * (1 + 0.5 * chance.random((size, size)))
    costs = (np.ceil(legs * 10) * 100).astype(np.int64)
    np.fill_diagonal(costs, 1 << 40)  # there is no rest
    marks = np.eye(size, dtype=np.bool_)
    if kind == "several marks to a target":
        kinds = max(2, size // 2)
        marks = chance.random((size, kinds)) < 0.15
        marks[np.arange(size), np.arange(size) % kinds] = True
    return shortest(costs), marks


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("seed", SEEDS)
def test_it_lies_between_its_bound_and_a_little_above_the_best(kind: str, seed: int) -> None:
    between, marks = case(kind, seed)
    best_ms = HeldKarp(between, marks).cost_ms
    tour = LocalSearch(between, marks)
    first_ms = tour.cost_ms
    assert tour.bound_ms == 0
    tour.improve()
    assert tour.bound_ms <= best_ms <= tour.cost_ms <= first_ms
    assert tour.cost_ms <= 1.06 * best_ms
    assert cost_of(between, tour.cycle()) == tour.cost_ms
    assert marks[tour.cycle()].any(axis=0).all()


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("seed", SEEDS)
def test_through_any_node_it_is_a_tour_of_the_cost_it_says(kind: str, seed: int) -> None:
    between, marks = case(kind, seed)
    tour, exact = LocalSearch(between, marks), HeldKarp(between, marks)
    to_targets, from_targets = costs_of(between)
    costs, least = (
        tour.costs_through(to_targets, from_targets),
        exact.costs_through(to_targets, from_targets),
    )
    for node in range(len(between)):
        order = tour.order_after(to_targets[:, node], from_targets[:, node])
        assert sorted(order) == sorted(tour.cycle())
        assert cost_of(between, [node, *order]) == costs[node] >= least[node]
        assert node not in tour.cycle() or costs[node] == tour.cost_ms


@pytest.mark.slow
@pytest.mark.long
@pytest.mark.parametrize("seed", range(2))
def test_over_50_sites_the_bound_is_near(seed: int) -> None:
    between, marks = case("symmetric", seed, targets=50)
    tour = LocalSearch(between, marks)
    tour.improve()
    assert 0.95 * tour.cost_ms <= tour.bound_ms <= tour.cost_ms


def test_on_a_circle_the_best_is_found_and_proved() -> None:
    """The shortest tour over points on a circle goes along it."""
    size = 24
    angles = np.random.default_rng(5).permutation(size) * 2 * np.pi / size
    where = 1000 * np.array([np.cos(angles), np.sin(angles)]).T
    legs = np.hypot(*(where[:, None] - where).transpose(2, 0, 1)).round().astype(np.int64) * 100
    np.fill_diagonal(legs, 1 << 40)
    tour = LocalSearch(shortest(legs), np.eye(size, dtype=np.bool_))
    tour.improve()
    assert tour.cost_ms == size * legs[legs > 0].min()
    assert tour.bound_ms >= 0.999 * tour.cost_ms


def test_one_target_with_all_marks_is_a_cycle() -> None:
    """At the only target the path there and back is empty, but a loop is not."""
    between = np.array([[700, 900], [800, 1700]])
    tour = LocalSearch(between, np.array([[True, True], [True, False]]))
    assert tour.cycle() == [0]
    to_targets, from_targets = costs_of(between)
    assert tour.costs_through(to_targets, from_targets).tolist() == [700, 1700]
    assert tour.order_after(to_targets[:, 0], from_targets[:, 0]) == [0]
    tour.improve()
    assert tour.bound_ms <= tour.cost_ms == 700


@pytest.mark.long
def test_equal_problems_have_equal_tours() -> None:
    cycles = []
    for _ in range(2):
        tour = LocalSearch(*case("symmetric", 3, targets=20))
        tour.improve()
        cycles.append(tour.cycle())
    assert cycles[0] == cycles[1]
