"""Tours over targets: exact where the tables are small enough, and bounded where they are not."""

from __future__ import annotations

import numpy as np
import pytest
from reference_tours import shortest

from companion.planning.builtin.costs import Costs
from companion.planning.builtin.gtsp import tours
from companion.planning.builtin.held_karp import HeldKarp, table_additions
from companion.planning.builtin.local_search import LocalSearch
from companion.planning.builtin.one_tree import lower_bound_ms


def on_a_random_map(targets: int, seed: int) -> Costs:
    """Costs in tenths of a second, which differ by direction."""
    chance = np.random.default_rng(seed)
    return shortest(100 * chance.integers(1, 60, (targets, targets)))


def test_tours_are_exact_up_to_the_additions_that_are_allowed() -> None:
    between, marks = on_a_random_map(6, 0), np.eye(6, dtype=np.bool_)
    needed = table_additions(marks)
    exact, bounded = (tours(between, marks, most) for most in (needed, needed - 1))
    assert isinstance(exact, HeldKarp) and exact.is_exact
    assert isinstance(bounded, LocalSearch) and not bounded.is_exact
    cost_ms = exact.cost_ms
    for each in (exact, bounded):
        each.improve()
        assert each.bound_ms <= cost_ms <= each.cost_ms
    assert exact.cost_ms == exact.bound_ms == cost_ms


@pytest.mark.slow
@pytest.mark.parametrize("targets", [1, 2, 3, 5, 9])
@pytest.mark.parametrize("seed", range(4))
def test_no_tour_is_shorter_than_the_1_tree_bound(targets: int, seed: int) -> None:
    between, marks = on_a_random_map(targets, seed), np.eye(targets, dtype=np.bool_)
    cost_ms = HeldKarp(between, marks).cost_ms
    bound_ms = lower_bound_ms(between, marks, cost_ms)
    assert 0 <= bound_ms <= cost_ms
    assert bound_ms % 100 == 0  # as all costs
