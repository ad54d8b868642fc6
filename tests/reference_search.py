"""The best cycle of the product by definition: one node after the other, nothing left out.

Shares no code with the planner's search: sets in place of bits, the automata as they are, and
Dijkstra's algorithm over (node, marks met) from every node. For small problems. A cycle leads the
automata back to where they were; a loop need not (`reference_lassos.py`). `shortest_tour`
is the same question where only the order of sites is asked for.

Source: Held and Karp, A dynamic programming approach to sequencing problems, 1962.
"""

from __future__ import annotations

import heapq
import itertools
import operator
from collections.abc import Iterable, Mapping, Sequence

from companion.planning.lasso import Letter, Problem

Node = tuple[Letter, tuple[int, ...]]
Step = tuple[Node, int, int]
"""Target, cost and marks."""


def edges(asked: Problem) -> dict[Node, list[tuple[Node, int, int, int]]]:
    """Target, action, cost and marks of the edges of every reachable node (Section III-A)."""
    automata = [c.automaton for c in asked.conjuncts]
    offsets = list(itertools.accumulate((a.marks for a in automata), initial=0))[:-1]
    found: dict[Node, list[tuple[Node, int, int, int]]] = {}
    todo = initial(asked)
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


def initial(asked: Problem) -> list[Node]:
    """The nodes at which a plan begins."""
    return [(asked.facts, states) for states in itertools.product(*asked.automaton_states)]


def prefixes(asked: Problem) -> dict[Node, int]:
    """Cost of the shortest path from the start to every node."""
    graph = {node: [(t, c, 0) for t, _, c, _ in steps] for node, steps in edges(asked).items()}
    reached = _dijkstra(graph, [(node, 0, 0) for node in initial(asked)])
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
    reached, shortest = prefixes(asked), laps(asked)
    return min(((lap, reached[node]) for node, lap in shortest.items()), default=None)


def best_sum(asked: Problem) -> int | None:
    """The least cost of prefix and lap together."""
    reached, shortest = prefixes(asked), laps(asked)
    return min((lap + reached[node] for node, lap in shortest.items()), default=None)


def best_bottleneck(asked: Problem, unit_ms: int) -> int | None:
    """The least worst time between two meetings of the same mark.

    Args:
        unit_ms: all costs are multiples of this.
    """
    graph = edges(asked)
    marks = sum(c.automaton.marks for c in asked.conjuncts)
    longest = best_lap_and_prefix(asked)  # on any lap no wait is longer than the lap
    if longest is None:
        return None
    low, high = 0, longest[0] // unit_ms  # impossible, possible
    while high - low > 1:
        middle = (low + high) // 2
        if _can_go_on(graph, marks, middle * unit_ms):
            high = middle
        else:
            low = middle
    return high * unit_ms


def _can_go_on(
    graph: Mapping[Node, list[tuple[Node, int, int, int]]], marks: int, limit_ms: int
) -> bool:
    """Whether a run can go on for ever with no mark unmet for longer than a limit."""
    following: dict[tuple[Node, tuple[int, ...]], list[tuple[Node, tuple[int, ...]]]] = {}
    todo = [(node, (0,) * marks) for node in graph]
    while todo:
        node, waits = state = todo.pop()
        if state in following:
            continue
        following[state] = [
            (target, tuple(0 if met >> m & 1 else wait + cost for m, wait in enumerate(waits)))
            for target, _, cost, met in graph[node]
            if max(waits) + cost <= limit_ms
        ]
        todo += following[state]
    while dead := [state for state, after in following.items() if not after]:
        for state in dead:
            del following[state]
        following = {s: [t for t in after if t in following] for s, after in following.items()}
    return bool(following)


def shortest_tour(sites: Sequence[str], legs: Mapping[tuple[str, str], int]) -> int:
    """The shortest closed walk over all sites, by dynamic programming over sets of sites.

    Args:
        legs: cost of the direct leg between places; the tour may lead over other places.
    """
    costs = _shortest_paths(legs)
    first, *others = sites
    if not others:
        return min(costs[first, p] + costs[p, first] for p, q in costs if p != first and q == first)
    far = 1 + len(sites) * max(costs.values())
    into = [[costs[a, b] if a != b else far for a in others] for b in others]
    begun = [costs[first, b] for b in others]
    best: list[list[int]] = [[]]  # for each set of sites, by the last of them
    for visited in range(1, 1 << len(others)):
        best.append(
            [
                far
                if not visited >> last & 1
                else begun[last]
                if visited == 1 << last
                else min(map(operator.add, best[visited ^ 1 << last], into[last]))
                for last in range(len(others))
            ]
        )
    return min(whole + costs[a, first] for whole, a in zip(best[-1], others, strict=True))


def _shortest_paths(legs: Mapping[tuple[str, str], int]) -> dict[tuple[str, str], int]:
    """Floyd and Warshall's algorithm; every place has to be reachable from every other."""
    places = sorted({place for pair in legs for place in pair})
    costs = {pair: legs.get(pair, 1 << 40) for pair in itertools.permutations(places, 2)}
    for via, a, b in itertools.product(places, repeat=3):
        if a != b and via not in (a, b):
            costs[a, b] = min(costs[a, b], costs[a, via] + costs[via, b])
    return costs


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
