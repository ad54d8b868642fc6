"""The shortest lap that a battery lasts for, by definition: every level of charge is looked at.

Shares no code with the planner's search, and none of its arguments: not that a lap may begin at a
floor, not that the vehicle had best arrive at a dock with the least. A state is a node of the
product (`reference_search.py`), the marks that were met, and a whole level; each charge leads to
every level that there is. For small problems with few levels.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from reference_search import Node, edges, initial
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra

from companion.planning.charger import Charger
from companion.planning.domain import WAIT, Action
from companion.planning.lasso import Energy, Lasso, Letter, Problem

REST_MS = WAIT.cost_ms


def place_of(facts: Letter) -> str:
    """Where the vehicle is."""
    return next(fact.arguments[0] for fact in facts if fact.predicate == "at")


def drained(energy: Energy, action: Action) -> int:
    """What an action takes that does not charge."""
    return energy.rest if action is WAIT else action.drain


def departures(charger: Charger, level: int) -> Iterator[tuple[int, int]]:
    """The levels that a charge may lead to, and how long it takes."""
    if level < charger.floor:
        return
    landed = level - charger.landing
    for top in range(landed, len(charger.times_ms)):
        taken_ms = charger.overhead_ms + int(charger.times_ms[top] - charger.times_ms[landed])
        if top >= charger.take_off:
            yield top - charger.take_off, taken_ms


@dataclass
class _Edge:
    start: int
    end: int
    action: Action
    marks: int


class EnergyReference:
    """All laps of a problem.

    Args:
        asked: with energy.
    """

    def __init__(self, asked: Problem) -> None:
        assert asked.energy is not None
        self._energy = asked.energy
        self._full = len(asked.energy.percents) - 1
        graph = edges(asked)
        self._nodes: list[Node] = list(graph)
        number = {node: i for i, node in enumerate(self._nodes)}
        self._edges = [
            _Edge(number[node], number[end], asked.actions[action], marks)
            for node, steps in graph.items()
            for end, action, _, marks in steps
        ]
        self._every = (1 << sum(c.automaton.marks for c in asked.conjuncts)) - 1
        far = self._full + 1
        places = [place_of(facts) for facts, _ in self._nodes]
        self._floors = [self._energy.floors.get(place, far) for place in places]
        self._rests = [self._energy.rests.get(place, far) for place in places]
        self._most = self._highest([number[node] for node in initial(asked)])

    def best_ms(self) -> int | None:
        """The shortest lap; None if there is none."""
        return REST_MS if self._can_rest() else self._shortest_ms()

    def _highest(self, starts: list[int]) -> list[int]:
        """The highest level with which each node can be reached; -1 for none."""
        most = [-1] * len(self._nodes)
        for start in starts:
            if self._energy.level >= self._floors[start]:
                most[start] = self._energy.level
        has_changed = True
        while has_changed:
            has_changed = False
            for edge in self._edges:
                level = most[edge.start]
                if level < 0:
                    continue
                if edge.action.charger is None:
                    after = level - drained(self._energy, edge.action)
                else:
                    after = max((d for d, _ in departures(edge.action.charger, level)), default=-1)
                if after >= self._floors[edge.end] and after > most[edge.end]:
                    most[edge.end] = after
                    has_changed = True
        return most

    def _can_rest(self) -> bool:
        """Whether the vehicle can come to rest: steps of rest that lead back to a node."""
        resting = [e for e in self._edges if e.action is WAIT]
        begins = [n for n, most in enumerate(self._most) if most >= self._rests[n]]
        for begin in begins:
            reached, pending = set[tuple[int, int]](), [(begin, 0)]
            while pending:
                node, met = pending.pop()
                for edge in resting:
                    state = edge.end, met | edge.marks
                    if edge.start == node and state not in reached:
                        reached.add(state)
                        pending.append(state)
            if (begin, self._every) in reached:
                return True
        return False

    def _shortest_ms(self) -> int | None:
        """The shortest lap that charges, from each level before each of its charges."""
        levels, sets = self._full + 1, self._every + 1
        states = len(self._nodes) * sets * levels

        def state(node: int, met: int, level: int) -> int:
            return (node * sets + met) * levels + level

        best: dict[tuple[int, int], int] = {}

        def add(start: int, end: int, cost_ms: int) -> None:
            best[start, end] = min(cost_ms, best.get((start, end), cost_ms))

        begins: list[tuple[int, int]] = []  # node and level
        for edge in self._edges:
            charger, floor = edge.action.charger, self._floors[edge.end]
            for level in range(self._floors[edge.start], levels):
                ends = [(level - drained(self._energy, edge.action), edge.action.cost_ms)]
                if charger is not None:
                    ends = list(departures(charger, level))
                for after, cost_ms in ends:
                    if after < floor:
                        continue
                    for met in range(sets):
                        begin, end = state(edge.start, met, level), edge.marks | met
                        add(begin, state(edge.end, end, after), cost_ms)
                    if charger is not None and level <= self._most[edge.start]:
                        source = states + len(begins)
                        add(source, state(edge.end, edge.marks, after), cost_ms)
                if charger is not None and charger.floor <= level <= self._most[edge.start]:
                    begins.append((edge.start, level))
        if not begins:
            return None
        size = states + len(begins)
        starts, ends_ = (np.array(part) for part in zip(*best, strict=True))
        matrix = csr_array((np.array([*best.values()], float), (starts, ends_)), shape=(size, size))
        costs = dijkstra(matrix, indices=range(states, size))
        laps = [
            costs[i, state(node, self._every, level) : state(node, self._every, self._full) + 1]
            for i, (node, level) in enumerate(begins)
        ]
        least = min(lap.min() for lap in laps)
        return int(least) if np.isfinite(least) else None


def flown(asked: Problem, lasso: Lasso, laps: int) -> list[int]:
    """The levels at the positions of a plan, flown on paper for some laps; it keeps all floors."""
    energy = asked.energy
    assert energy is not None
    level, facts, levels = energy.level, asked.facts, []
    for action in (*lasso.prefix, *(lasso.loop * (0 if lasso.ends_at_rest else laps))):
        levels.append(level)
        assert action.is_applicable(facts)
        assert level >= energy.floors[place_of(facts)], (action, level)
        if action.charger is None:
            level -= drained(energy, action)
        else:
            assert action.charge_to is not None
            least = level - action.charger.landing - action.charger.take_off
            level = max(action.charge_to, least)
            assert level in [after for after, _ in departures(action.charger, levels[-1])]
        facts = action.apply(facts)
    needed = energy.rests if lasso.ends_at_rest else energy.floors
    assert level >= needed[place_of(facts)]
    return [*levels, level]
