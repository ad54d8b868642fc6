"""Searches for loops of actions whose word is accepted, whatever the automata do in early laps.

A loop may be entered wherever its word is accepted. The automata then need not return to the states
in which they were, only to states from which the following laps are also accepted. So this search
runs over the facts and the profiles of the lap so far (`lap_profiles.py`), and the automata judge
the lap when the facts are the same again. It is A*; its heuristic is the shortest path back over
the facts that a missing mark needs.

The search is exact, but the number of profiles doubles with each mark. So it is only used for what
the tours over targets leave open (`loop_entry.py`), with its own limit.
"""

from __future__ import annotations

import heapq
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from scipy.sparse import csr_array

from companion.errors import SearchLimit
from companion.ltl.bitsets import indices
from companion.planning.builtin.costs import UNREACHABLE_MS, Costs
from companion.planning.builtin.lap_profiles import EMPTY, LapProfiles
from companion.planning.builtin.product import Product
from companion.planning.builtin.shortest_paths import costs_between
from companion.planning.effort import LOOP_STEP_US
from companion.slices import spent

_PLACE_US = 0.01
_PROFILE_US = 0.4
_STEP_US = 0.5

Profiles = tuple[int, ...]
"""The profile of a word for each of the automata."""

_Node = tuple[int, Profiles]
"""The number of the facts, and the profiles of the lap so far."""

Rank = tuple[int, int]
"""Smaller is better: the minimised cost, then the prefix."""


class Entry(NamedTuple):
    """A node at whose product state a loop may begin, and the cost of the prefix to it."""

    prefix_ms: int
    node: int


@dataclass(frozen=True, slots=True)
class EnteredLoop:
    """A loop of actions, and the product state at which it is entered."""

    rank: Rank
    entry: Entry
    lap_ms: int
    actions: tuple[int, ...]


class _Step(NamedTuple):
    end: int  # the number of the facts
    cost_ms: int
    action: int


class LoopSearch:
    """Searches for loops of a product.

    Args:
        product: an explored product.
        max_steps: most edges that all searches together may examine.
    """

    def __init__(self, product: Product, max_steps: int) -> None:
        self._product, self._steps_left = product, max_steps
        self._profiles = [LapProfiles(automaton) for automaton in product.automata]
        self._after: dict[tuple[Profiles, int], Profiles] = {}

    def accepting(self, letters: Sequence[int], entries: Sequence[Entry]) -> Entry | None:
        """The first of some entries from which a lap is accepted, given the facts along the lap."""
        profiles: Profiles = (EMPTY,) * len(self._profiles)
        for facts in letters:
            profiles = self._longer(profiles, facts)
            spent(_PROFILE_US * len(profiles))
        return next((entry for entry in entries if self._accepts(profiles, entry)), None)

    def best(
        self,
        facts: int,
        entries: Sequence[Entry],
        rank: Callable[[int, int], Rank],
        known: Rank,
    ) -> EnteredLoop | None:
        """The best loop at some facts; None if none is better than the known one.

        Args:
            facts: where the loop begins and ends.
            entries: the entries at these facts, the one with the shortest prefix first.
            rank: computes the rank of a prefix and a lap.
            known: the rank to improve on.

        Raises:
            SearchLimit: there are too many edges.
        """
        if rank(entries[0].prefix_ms, 2 * self._product.least_ms) >= known:
            return self._best_step(facts, entries, rank, known)
        anchor = self._place_of[facts]
        left_ms = self._remaining(anchor)
        start: _Node = (anchor, (EMPTY,) * len(self._profiles))
        came_from: dict[_Node, tuple[_Node, int]] = {}
        lap_of = {start: 0}
        queue = [(left_ms(*start), 0, start)]
        best: EnteredLoop | None = None
        closed = set()
        shortest_ms = entries[0].prefix_ms
        while queue:
            least_ms, lap_ms, node = heapq.heappop(queue)
            if rank(shortest_ms, least_ms) >= known:
                break
            if node in closed:
                continue
            closed.add(node)
            place, profiles = node
            if place == anchor and lap_ms:
                entry = next((e for e in entries if self._accepts(profiles, e)), None)
                if entry is not None and rank(entry.prefix_ms, lap_ms) < known:
                    known = rank(entry.prefix_ms, lap_ms)
                    best = EnteredLoop(known, entry, lap_ms, _traced(came_from, start, node))
            self._steps_left -= len(self._steps[place])
            spent(LOOP_STEP_US * len(self._steps[place]))
            if self._steps_left < 0:
                raise SearchLimit("edges of the search for loops")
            for end, cost_ms, action in self._steps[place]:
                after = (end, self._longer(profiles, self._facts[end]))
                if lap_ms + cost_ms < lap_of.get(after, UNREACHABLE_MS):
                    lap_of[after] = lap_ms + cost_ms
                    came_from[after] = (node, action)
                    bound_ms = lap_ms + cost_ms + left_ms(*after)
                    heapq.heappush(queue, (bound_ms, lap_ms + cost_ms, after))
        return best

    def _best_step(
        self, facts: int, entries: Sequence[Entry], rank: Callable[[int, int], Rank], known: Rank
    ) -> EnteredLoop | None:
        """The best loop of one action, if loops of two would cost too much."""
        entry = self.accepting([facts], entries)
        if entry is None:
            return None
        found = [
            EnteredLoop(rank(entry.prefix_ms, cost_ms), entry, cost_ms, (action,))
            for after, action, cost_ms in self._product.system.steps(facts)
            if after == facts
        ]
        best = min(found, key=lambda loop: loop.rank, default=None)
        return best if best and best.rank < known else None

    def _accepts(self, profiles: Profiles, entry: Entry) -> bool:
        states = self._product.automaton_states(entry.node)
        return all(
            state in each.accepting(profile)
            for each, profile, state in zip(self._profiles, profiles, states, strict=True)
        )

    def _longer(self, profiles: Profiles, facts: int) -> Profiles:
        key = (profiles, facts)
        found = self._after.get(key)
        if found is None:
            pairs = zip(self._profiles, profiles, strict=True)
            found = self._after[key] = tuple(each.after(p, facts) for each, p in pairs)
        return found

    @cached_property
    def _place_of(self) -> dict[int, int]:
        nodes = sorted(set(self._product.facts_of))
        return {self._product.facts(node): place for place, node in enumerate(nodes)}

    @cached_property
    def _facts(self) -> list[int]:
        return list(self._place_of)

    @cached_property
    def _steps(self) -> list[list[_Step]]:
        spent(_STEP_US * len(self._product.ends))
        return [
            [
                _Step(self._place_of[after], cost_ms, action)
                for after, action, cost_ms in self._product.system.steps(facts)
                if after in self._place_of
            ]
            for facts in self._facts
        ]

    @cached_property
    def _between(self) -> Costs:
        """Cost of the shortest path from facts to facts, by number."""
        cheapest: dict[tuple[int, int], int] = {}
        for place, steps in enumerate(self._steps):
            for step in steps:
                known_ms = cheapest.get((place, step.end), UNREACHABLE_MS)
                cheapest[place, step.end] = min(step.cost_ms, known_ms)
        places, ends = zip(*cheapest, strict=True)
        shape = (len(self._facts), len(self._facts))
        matrix = csr_array((np.array([*cheapest.values()], float), (places, ends)), shape=shape)
        return costs_between(matrix, range(len(self._facts)))

    @cached_property
    def _targets(self) -> list[tuple[int, int, list[int]]]:
        """Automaton, mark (a bit) and facts with that mark, for automata of one state."""
        found = []
        for number, automaton in enumerate(self._product.automata):
            if automaton.states > 1:
                continue
            met = [sum(m for _, m in automaton.successors(0, facts)) for facts in self._facts]
            for mark in indices(automaton.every_mark):
                places = [place for place, marks in enumerate(met) if marks >> mark & 1]
                found.append((number, 1 << mark, places))
        return found

    def _remaining(self, anchor: int) -> Callable[[int, Profiles], int]:
        """A lower bound for the path from some facts, with the lap so far, back to an anchor.

        Each missing mark of an automaton with one state has to be met on that path.
        """
        between = self._between
        back_ms: list[int] = between[:, anchor].tolist()
        over_ms = []
        for number, mark, places in self._targets:
            spent(_PLACE_US * len(between) * len(places))
            legs = between[:, places] + between[places, anchor]
            over_ms.append((number, mark, legs.min(axis=1, initial=UNREACHABLE_MS).tolist()))

        def least_ms(place: int, profiles: Profiles) -> int:
            least = back_ms[place]
            for number, mark, costs in over_ms:
                if (
                    costs[place] > least
                    and not self._profiles[number].marks(profiles[number]) & mark
                ):
                    least = costs[place]
            return least

        return least_ms


def _traced(
    came_from: dict[_Node, tuple[_Node, int]], start: _Node, node: _Node
) -> tuple[int, ...]:
    """The actions of the path to a node."""
    actions = []
    while node != start:
        node, action = came_from[node]
        actions.append(action)
    return tuple(reversed(actions))
