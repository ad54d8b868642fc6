"""A task reduced to what can change: without constants, and without unreachable actions.

Actions that can never be applied are left out, and so is each fact that keeps its value: events,
beliefs, places that cannot be reached. The facts that change are grouped into variables: the places
of one vehicle are one variable with as many values, because exactly one of them holds at a time.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property

from companion.ltl.automaton import BuchiAutomaton
from companion.mission.facts import Fact
from companion.planning.builtin.masked_actions import KnownActions
from companion.planning.builtin.transition_system import TransitionSystem
from companion.planning.domain import Action, ConditionalEffect
from companion.planning.lasso import Conjunct, Problem

LARGEST_COST = 2**31 - 1
"""Limit because Fast Downward adds up costs in 32 bits."""


@dataclass(frozen=True)
class ReducedTask:
    """The part of a problem that can change.

    Attributes:
        actions: those that may ever become applicable, without constants; parallel to `origins`.
        origins: the same actions, as in the problem.
        changing: the facts that may change, sorted.
        init: those of them that hold now.
        always: the facts that always hold; all others never do.
    """

    actions: tuple[Action, ...]
    origins: tuple[Action, ...]
    changing: tuple[Fact, ...]
    init: frozenset[Fact]
    always: frozenset[Fact]

    @property
    def has_conditional_effects(self) -> bool:
        """Whether the effect of some action depends on the facts before it."""
        return any(action.conditional for action in self.actions)

    @cached_property
    def unit_ms(self) -> int:
        """The largest unit of which all costs are multiples."""
        return math.gcd(*(action.cost_ms for action in self.actions)) or 1

    def cost(self, action: Action) -> int:
        """The cost of an action in units."""
        return action.cost_ms // self.unit_ms

    def constants(self, propositions: Iterable[str]) -> Mapping[str, bool]:
        """The values of those propositions that are constant."""
        changing = frozenset(self.changing)
        return {p: p in self.always for p in propositions if p not in changing}

    @cached_property
    def variables(self) -> tuple[tuple[Fact, ...], ...]:
        """Groups of facts of which exactly one holds at a time; other facts are groups of one."""
        groups: dict[str, list[Fact]] = {}
        for fact in self.changing:
            groups.setdefault(fact.predicate, []).append(fact)
        return tuple(
            values
            for group in groups.values()
            for values in ([tuple(group)] if self._is_variable(group) else [(f,) for f in group])
        )

    def _is_variable(self, facts: list[Fact]) -> bool:
        """Whether exactly one holds now, and each action that adds one deletes the one it needs."""
        group = frozenset(facts)
        return len(group & self.init) == 1 and all(
            (
                not (group & action.adds or group & action.deletes)
                or (
                    len(group & action.adds) == 1
                    and len(group & action.deletes) == 1
                    and group & action.deletes <= action.requires
                )
            )
            and not any(group & (e.adds | e.deletes) for e in action.conditional)
            for action in self.actions
        )

    def lap_weight(self, automata: Iterable[BuchiAutomaton]) -> int:
        """The factor by which actions cost more in the loop, so that the lap comes first.

        A shortest prefix passes no state of the product twice, which limits its cost. If a weight
        above that limit would make costs too large, a smaller one is used, and then the prefix also
        counts.
        """
        states = math.prod(max(2, len(values)) for values in self.variables)
        states *= math.prod(max(1, automaton.states) for automaton in automata)
        costs = [self.cost(action) for action in self.actions]
        needed = states * max(costs, default=1) + 1
        possible = max(1, LARGEST_COST // (2 * (sum(costs) + 1)))
        return min(needed, possible)


def reduced_task(problem: Problem) -> ReducedTask:
    """What can change in a problem, by relaxed reachability (`transition_system.py`)."""
    system = TransitionSystem(problem.actions, problem.facts, KnownActions())
    possible = [problem.actions[number] for number in system.possible]
    named = problem.facts.union(*(a.adds | a.deletes | _conditionally(a) for a in possible))
    changing = frozenset(f for f in named if system.constant_value(f) is None)
    always = problem.facts - changing
    return ReducedTask(
        tuple(_without_constants(action, changing, always) for action in possible),
        tuple(possible),
        tuple(sorted(changing)),
        problem.facts & changing,
        always,
    )


def _conditionally(action: Action) -> frozenset[Fact]:
    return frozenset().union(*(e.adds | e.deletes for e in action.conditional))


def _without_constants(
    action: Action, changing: frozenset[Fact], always: frozenset[Fact]
) -> Action:
    return replace(
        action,
        requires=action.requires & changing,
        forbids=action.forbids & changing,
        adds=action.adds & changing,
        deletes=(action.deletes - action.adds) & changing,
        conditional=tuple(
            ConditionalEffect(
                effect.requires & changing,
                effect.forbids & changing,
                effect.adds & changing,
                effect.deletes & changing,
            )
            for effect in action.conditional
            if effect.requires <= changing | always and not effect.forbids & always
        ),
    )


def accepting_states(automaton: BuchiAutomaton) -> frozenset[int]:
    """The accepting states of a state-based automaton with one acceptance set."""
    return frozenset(t.source for t in automaton.transitions if t.marks)


def is_state_based(conjunct: Conjunct) -> bool:
    """Whether the paper's encoding can use a conjunct's automaton."""
    return conjunct.automaton.marks == 1 and conjunct.automaton.has_state_acceptance
