"""Masks that are kept from plan to plan are those that would be made anew."""

from __future__ import annotations

import random
from dataclasses import replace

from hypothesis import given
from hypothesis import strategies as st
from random_missions import random_mission

from companion.mission.facts import Fact
from companion.planning.builtin.masked_actions import ActionGroup, KnownActions
from companion.planning.domain import Action


def told(
    groups: list[ActionGroup],
    known: KnownActions,
    facts: frozenset[Fact],
    changing: frozenset[Fact],
) -> object:
    """What groups of actions do where some facts hold, in facts that change."""
    state = known.state(facts)
    return sorted(
        (number, cost_ms, sorted(known.bits.facts(end) & changing))
        for group in groups
        if group.is_applicable(state)
        for number, cost_ms, end in zip(group.numbers, group.costs, group.ends(state), strict=True)
    )


@given(st.integers(0, 10**6))
def test_other_costs_and_fewer_actions_are_taken_over(seed: int) -> None:
    chance = random.Random(seed)
    problem, _ = random_mission(chance)
    known = KnownActions(problem.actions)
    for _ in range(3):
        actions = tuple(_changed(chance, problem.actions))
        known.keep(actions)
        anew = KnownActions(actions)
        groups, others = (k.given(actions, problem.facts) for k in (known, anew))
        changing = frozenset[Fact]().union(*(a.adds | a.deletes for a in actions))
        facts = problem.facts
        assert told(groups, known, facts, changing) == told(others, anew, facts, changing)


def _changed(chance: random.Random, actions: tuple[Action, ...]) -> list[Action]:
    """Some of the actions, of which some cost something else, or do something else."""
    kept = [action for action in actions if chance.random() < 0.8]
    for place, action in enumerate(kept):
        if chance.random() < 0.3:
            kept[place] = replace(action, cost_ms=100 * chance.randint(2, 9))
        elif chance.random() < 0.1:
            kept[place] = replace(action, deletes=frozenset())
    return kept
