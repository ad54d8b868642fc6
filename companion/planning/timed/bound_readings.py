"""Tells what each position of a product does with the clocks of time bounds."""

from __future__ import annotations

from collections.abc import Callable
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from companion.ltl.formula import Formula, atoms
from companion.ltl.semantics import holds
from companion.ltl.time_bounds import Response, Revisit, TimeBound
from companion.mission.facts import Fact
from companion.planning.builtin.product import Product
from companion.planning.domain import Action
from companion.planning.lasso import Problem
from companion.slices import spent

_NODE_US, _READING_US, _ACTION_US = 1.0, 10.0, 1.0


class BoundReading(IntEnum):
    """What a position does with a clock."""

    NOTHING = 0
    GOAL = 1
    TRIGGER = 2


def reading_of(bound: TimeBound, is_true: Callable[[Formula], bool]) -> BoundReading:
    """What a position does with the clock of a bound, given what holds there."""
    if is_true(bound.goal):
        return BoundReading.GOAL
    is_begun = isinstance(bound, Response) and is_true(bound.trigger)
    return BoundReading.TRIGGER if is_begun else BoundReading.NOTHING


def may_any_run(problem: Problem) -> bool:
    """Whether any clock of a problem may ever run; it may not if no action starts one."""
    waiting: list[Response] = []
    for conjunct, elapsed_ms in zip(problem.conjuncts, problem.clocks_ms, strict=True):
        if elapsed_ms is not None or isinstance(conjunct.bound, Revisit):
            return True
        if isinstance(conjunct.bound, Response):
            waiting.append(conjunct.bound)
    if not waiting:
        return False
    spent(_ACTION_US * len(problem.actions))
    changing = frozenset[Fact]().union(*(_changed(action) for action in problem.actions))
    letters = [problem.facts, problem.facts | problem.unread]
    return any(
        not changing.isdisjoint(atoms(bound.trigger))
        or any(holds(bound.trigger, [], [letter]) for letter in letters)
        for bound in waiting
    )


def _changed(action: Action) -> frozenset[Fact]:
    changes = [action.adds, action.deletes]
    changes += [each for effect in action.conditional for each in (effect.adds, effect.deletes)]
    return frozenset[Fact]().union(*changes)


class Letters:
    """The letters of a product's nodes, as read by formulas without temporal operators."""

    def __init__(self, product: Product) -> None:
        self._product = product

    def where(self, formula: Formula) -> NDArray[np.bool_]:
        """(nodes,) where a formula holds."""
        product = self._product
        named = sorted(atoms(formula))
        constants = {name: product.system.constant_value(name) for name in named}
        always = frozenset(name for name, value in constants.items() if value)
        bits = {name: product.bit(name) for name, value in constants.items() if value is None}
        mask = sum(bits.values())
        known: dict[int, bool] = {}
        found = np.zeros(product.nodes, np.bool_)
        for node in range(product.nodes):
            held = product.facts(node) & mask
            if held not in known:
                spent(_READING_US)
                letter = always.union(name for name, bit in bits.items() if bit & held)
                known[held] = holds(formula, [], [letter])
            found[node] = known[held]
        spent(_NODE_US * product.nodes)
        return found

    def of(self, node: int) -> frozenset[str]:
        """All that holds at a node."""
        return self._product.letter(node)
