"""The shortest lap that keeps all bounds, by definition: every state of the clocks is looked at.

Shares no code with the planner's search, and none of its arguments: not that a smaller clock is
better, not that a clock shows the same at the end of every lap. A state is a node of the product
(`reference_search.py`) and what all clocks show. For small problems with whole seconds.
"""

from __future__ import annotations

import heapq
from collections import defaultdict

import networkx
from reference_search import Node, edges, initial

from companion.ltl.formula import Formula
from companion.ltl.semantics import holds
from companion.planning.domain import WAIT
from companion.planning.lasso import Problem

REST_MS = 1000
State = tuple[Node, tuple[int | None, ...]]


class TimeReference:
    """All plans of a problem.

    Args:
        asked: with bounds.
    """

    def __init__(self, asked: Problem) -> None:
        self._asked = asked
        self._every = (1 << sum(c.automaton.marks for c in asked.conjuncts)) - 1
        self._steps: dict[State, list[tuple[State, int, int]]] = {}
        untimed = edges(asked)
        starts = [(node, asked.clocks_ms) for node in initial(asked)]
        todo = [*starts]
        while todo:
            state = todo.pop()
            if state in self._steps:
                continue
            self._steps[state] = found = []
            node, clocks = state
            for end, number, cost_ms, marks in untimed[node]:
                action = asked.actions[number]
                took_ms = REST_MS if action is WAIT else action.cost_ms
                after = self._after(clocks, took_ms, end, is_first=state in starts)
                if after is not None:
                    found.append(((end, after), cost_ms, marks))
                    todo.append((end, after))

    def _after(
        self, clocks: tuple[int | None, ...], took_ms: int, end: Node, is_first: bool
    ) -> tuple[int | None, ...] | None:
        letter = end[0] | (self._asked.unread if is_first else frozenset())

        def is_true(formula: Formula) -> bool:
            return holds(formula, [], [letter])

        shown: list[int | None] = []
        for conjunct, elapsed_ms in zip(self._asked.conjuncts, clocks, strict=True):
            bound = conjunct.bound
            if bound is None:
                shown.append(None)
                continue
            reached_ms = None if elapsed_ms is None else elapsed_ms + took_ms
            if reached_ms is not None and reached_ms > bound.planned_ms:
                return None
            shown.append(bound.after(reached_ms, is_true))
        return tuple(shown)

    def best_ms(self) -> int | None:
        """The shortest lap; None if there is none."""
        graph = networkx.DiGraph()
        met: dict[tuple[State, State], int] = defaultdict(int)
        for state, steps in self._steps.items():
            for end, _, marks in steps:
                graph.add_edge(state, end)
                met[state, end] |= marks
        best: int | None = None
        for states in networkx.strongly_connected_components(graph):
            inside = [(a, b) for a in states for b in graph.successors(a) if b in states]
            marks = 0
            for pair in inside:
                marks |= met[pair]
            if inside and marks == self._every:
                best = self._shortest_ms(states, best)
        return best

    def _shortest_ms(self, states: set[State], best: int | None) -> int | None:
        for anchor in self._anchors(states):
            found = self._shortest_from(anchor, states, best)
            best = found if found is not None else best
        return best

    def _shortest_from(self, anchor: State, states: set[State], best: int | None) -> int | None:
        """The shortest lap through a state, if it is shorter than the best one that is known."""
        known: set[tuple[State, int]] = set()
        pending: list[tuple[int, int, State, int]] = [(0, 0, anchor, 0)]
        count = 0
        while pending:
            cost_ms, _, state, marks = heapq.heappop(pending)
            if cost_ms and (state, marks) in known:
                continue
            if cost_ms and state == anchor and marks == self._every:
                return cost_ms
            if cost_ms:
                known.add((state, marks))
            for end, more_ms, own in self._steps[state]:
                if end in states and (best is None or cost_ms + more_ms < best):
                    count += 1
                    heapq.heappush(pending, (cost_ms + more_ms, count, end, marks | own))
        return None

    def _anchors(self, states: set[State]) -> list[State]:
        """The states where the mark is met that is met at the fewest."""
        by_mark: dict[int, set[State]] = {}
        for mark in range(self._every.bit_length()):
            by_mark[mark] = {
                end
                for state in states
                for end, _, marks in self._steps[state]
                if end in states and marks >> mark & 1
            }
        fewest = min(by_mark.values(), key=len, default=states)
        return sorted(fewest, key=repr)
