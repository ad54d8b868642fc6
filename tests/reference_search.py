"""The best lasso by definition: the whole product, one node after the other, nothing left out.

Shares no code with the planner's search: sets in place of bits, the automata as they are, and
Dijkstra's algorithm over (node, marks met) from every node. For small problems.
"""

from __future__ import annotations

import heapq
import itertools
from collections.abc import Iterable

from companion.planning.lasso import Problem

Node = tuple[frozenset[str], tuple[int, ...]]
Step = tuple[Node, int, int]
"""Target, cost and marks."""


def edges(asked: Problem) -> dict[Node, list[tuple[Node, int, int, int]]]:
    """Target, action, cost and marks of the edges of every reachable node (Section III-A)."""
    automata = [c.automaton for c in asked.conjuncts]
    offsets = list(itertools.accumulate((a.marks for a in automata), initial=0))[:-1]
    found: dict[Node, list[tuple[Node, int, int, int]]] = {}
    todo = roots(asked)
    while todo:
        facts, states = node = todo.pop()
        if node in found:
            continue
        found[node] = []
        for number, action in enumerate(asked.actions):
            if not action.is_applicable(facts):
                continue
            after = action.apply(facts)
            reads = [
                [t for t in a.outgoing[z] if t.label.matches(after)]
                for a, z in zip(automata, states, strict=True)
            ]
            for steps in itertools.product(*reads):
                target = (after, tuple(t.target for t in steps))
                marks = {o + m for t, o in zip(steps, offsets, strict=True) for m in t.marks}
                bits = sum(1 << m for m in marks)
                found[node].append((target, number, action.cost_ms, bits))
                todo.append(target)
    return found


def roots(asked: Problem) -> list[Node]:
    """The nodes at which a plan begins."""
    return [(asked.facts, states) for states in itertools.product(*asked.automaton_states)]


def arrivals(asked: Problem) -> dict[Node, int]:
    """Cost of the shortest way from the start to every node."""
    graph = {node: [(t, c, 0) for t, _, c, _ in steps] for node, steps in edges(asked).items()}
    reached = _dijkstra(graph, [(root, 0, 0) for root in roots(asked)])
    return {node: cost for (node, _), cost in reached.items()}


def laps(asked: Problem) -> dict[Node, int]:
    """Cost of the shortest accepting loop through each node that has one."""
    every = (1 << sum(c.automaton.marks for c in asked.conjuncts)) - 1
    graph = {node: [(t, c, m) for t, _, c, m in steps] for node, steps in edges(asked).items()}
    found = {}
    for node in graph:
        starts = [(target, marks, cost) for target, cost, marks in graph[node]]
        reached = _dijkstra(graph, starts)
        if (node, every) in reached:
            found[node] = reached[node, every]
    return found


def best_lap_and_prefix(asked: Problem) -> tuple[int, int] | None:
    """The shortest lap, and the shortest prefix to one of that cost."""
    reached, rounds = arrivals(asked), laps(asked)
    return min(((lap, reached[node]) for node, lap in rounds.items()), default=None)


def best_sum(asked: Problem) -> int | None:
    """The least cost of prefix and lap together."""
    reached, rounds = arrivals(asked), laps(asked)
    return min((lap + reached[node] for node, lap in rounds.items()), default=None)


def _dijkstra(
    graph: dict[Node, list[Step]], starts: Iterable[tuple[Node, int, int]]
) -> dict[tuple[Node, int], int]:
    """Least cost to each node with each set of marks met on the way."""
    ticket = itertools.count()
    queue = [(cost, next(ticket), node, marks) for node, marks, cost in starts]
    heapq.heapify(queue)
    settled: dict[tuple[Node, int], int] = {}
    while queue:
        cost, _, node, met = heapq.heappop(queue)
        if (node, met) in settled:
            continue
        settled[node, met] = cost
        for target, step, marks in graph[node]:
            if (target, met | marks) not in settled:
                heapq.heappush(queue, (cost + step, next(ticket), target, met | marks))
    return settled
