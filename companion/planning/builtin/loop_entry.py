"""Finds the best lasso of all: its loop is entered as soon as the word is accepted from there.

The tours over targets (`loops.py`) give a cycle of the product, entered at one of its nodes. But a
loop of actions may also be entered from other automaton states, if some laps lead from them to a
cycle. And a cycle may be several laps of a shorter loop of actions. So:

- a loop of actions at some facts costs at least as much as the shortest cycle there, divided by the
  most laps that a cycle takes (`Product.max_laps`, which is 1 for nearly all automata);
- the known loop is tried from every state in which its facts are reached;
- if these leave a question open, `loop_search.py` examines all loops of actions.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from companion.errors import SearchLimit
from companion.planning.builtin.costs import UNREACHABLE_MS
from companion.planning.builtin.loop_search import Entry, LoopSearch, Rank
from companion.planning.builtin.loops import Loops
from companion.planning.builtin.product import Product
from companion.planning.builtin.shortest_paths import ShortestPaths
from companion.planning.effort import Effort
from companion.planning.objective import Objective


@dataclass(frozen=True, slots=True)
class ProductPlan:
    """A lasso as numbers of actions.

    Attributes:
        bound_ms: lower bound for the objective of all lassos.
        has_best_prefix: whether no lasso with this lap has a shorter prefix.
    """

    prefix: tuple[int, ...]
    loop: tuple[int, ...]
    prefix_ms: int
    lap_ms: int
    cost_ms: int
    bound_ms: int
    has_best_prefix: bool = False


def rank(objective: Objective, prefix_ms: int, lap_ms: int) -> Rank:
    """The rank; smaller is better: the minimised cost, then the prefix."""
    cost_ms = prefix_ms + lap_ms if objective is Objective.SUM else lap_ms
    return cost_ms, prefix_ms


def least_lap_ms(product: Product, cycle_ms: int) -> int:
    """The least cost of a loop of actions, given the least cost of a cycle of the product."""
    if cycle_ms <= product.least_ms:  # because a loop has at least one action
        return cycle_ms
    return max(product.least_ms, -(-cycle_ms // product.max_laps))


def entered_best(
    product: Product,
    components_loops: list[Loops],
    paths: ShortestPaths,
    objective: Objective,
    plan: ProductPlan,
    effort: Effort,
) -> ProductPlan:
    """The plan, or a better one, with what is proved about it.

    Args:
        components_loops: the loops of each component.
        plan: the best plan that enters a cycle of the product at one of the cycle's nodes.
        effort: the limits of the search.
    """
    is_exact = all(loops.is_exact for loops in components_loops)
    known = rank(objective, plan.prefix_ms, plan.lap_ms)
    try:
        least_at = _promising(product, components_loops, paths, objective, known, effort)
        is_best = is_exact and not least_at
        if least_at:
            entering = _Entering(product, paths, objective, least_at, effort)
            if len(plan.loop) > 1 or not is_exact:  # a loop of one action is found as quickly below
                plan = entering.with_the_same_loop(plan)
            if is_exact:
                plan = entering.with_any_loop(plan)
                is_best = True
    except SearchLimit:
        return plan
    return replace(plan, bound_ms=plan.cost_ms, has_best_prefix=True) if is_best else plan


def _promising(
    product: Product,
    components_loops: list[Loops],
    paths: ShortestPaths,
    objective: Objective,
    known: Rank,
    effort: Effort,
) -> dict[int, int]:
    """Facts where a better loop may begin (`Product.facts_of`), with a bound of its cost.

    Raises:
        SearchLimit: there are too many such facts.
    """
    least_at: dict[int, int] = {}
    for loops in components_loops:
        nodes = loops.nodes
        if product.max_laps == 1:  # then a loop is a cycle, entered at its nodes, and known
            nodes = nodes[paths.to_facts[nodes] < paths.from_start[nodes]]
        least_ms = least_lap_ms(product, loops.bound_ms)
        to_facts = paths.to_facts[nodes].tolist()
        nodes = nodes[[rank(objective, prefix_ms, least_ms) < known for prefix_ms in to_facts]]
        if loops.is_exact and len(nodes) * product.dijkstra_steps > effort.dijkstra_steps:
            raise SearchLimit(f"{effort.dijkstra_steps:,} steps of Dijkstra searches")
        for node, cycle_ms in _least_cycles(loops, nodes):
            lap_ms = least_lap_ms(product, cycle_ms)
            if rank(objective, int(paths.to_facts[node]), lap_ms) < known:
                facts = product.facts_of[node]
                least_at[facts] = min(lap_ms, least_at.get(facts, UNREACHABLE_MS))
    return least_at


class _Entering:
    """Looks for lassos with a better rank than that of a plan."""

    def __init__(
        self,
        product: Product,
        paths: ShortestPaths,
        objective: Objective,
        least_at: dict[int, int],
        effort: Effort,
    ) -> None:
        self._product, self._paths, self._objective = product, paths, objective
        self._least_at = {product.facts(facts): lap_ms for facts, lap_ms in least_at.items()}
        self._search = LoopSearch(product, effort.loop_steps)
        self._entries: dict[int, list[Entry]] = defaultdict(list)  # by facts
        for node, facts in enumerate(product.facts_of):
            if facts in least_at and product.state_of[node] == node:
                entry = Entry(int(paths.from_start[node]), node)
                self._entries[product.facts(node)].append(entry)
        for entries in self._entries.values():
            entries.sort()

    def _rank(self, prefix_ms: int, lap_ms: int) -> Rank:
        return rank(self._objective, prefix_ms, lap_ms)

    def _better_entries(self, facts: int, lap_ms: int, known: Rank) -> list[Entry]:
        """The entries at some facts for which a lap would have a better rank than the known one."""
        return [e for e in self._entries.get(facts, ()) if self._rank(e.prefix_ms, lap_ms) < known]

    def with_the_same_loop(self, plan: ProductPlan) -> ProductPlan:
        """The plan, with its loop entered at the best place."""
        facts = self._facts_along(plan)
        for begin in range(len(plan.loop)):
            known = self._rank(plan.prefix_ms, plan.lap_ms)
            entries = self._better_entries(facts[begin - 1], plan.lap_ms, known)
            if entries:
                lap = facts[begin:] + facts[:begin]
                entry = self._search.accepting(lap, entries)
                if entry is not None:
                    loop = plan.loop[begin:] + plan.loop[:begin]
                    better = self._plan(plan, entry, loop, plan.lap_ms)
                    return self.with_the_same_loop(better)
        return plan

    def _facts_along(self, plan: ProductPlan) -> list[int]:
        """The facts after each action of a plan's loop."""
        along = []
        here = self._product.system.start
        for action in (*plan.prefix, *plan.loop):
            here = self._product.system.after(here, action)
            along.append(here)
        return along[len(plan.prefix) :]

    def with_any_loop(self, plan: ProductPlan) -> ProductPlan:
        """The best plan with any loop.

        Raises:
            SearchLimit: it is not found within the limits.
        """
        known = self._rank(plan.prefix_ms, plan.lap_ms)
        ranked = {
            facts: self._rank(self._entries[facts][0].prefix_ms, lap_ms)
            for facts, lap_ms in self._least_at.items()
        }
        for facts in sorted(ranked, key=lambda facts: (ranked[facts], facts)):
            entries = self._better_entries(facts, self._least_at[facts], known)
            found = entries and self._search.best(facts, entries, self._rank, known)
            if found:
                plan = self._plan(plan, found.entry, found.actions, found.lap_ms)
                known = found.rank
        return plan

    def _plan(
        self, plan: ProductPlan, entry: Entry, loop: tuple[int, ...], lap_ms: int
    ) -> ProductPlan:
        prefix = self._paths.path_from_start(entry.node)
        cost_ms, _ = self._rank(entry.prefix_ms, lap_ms)
        return ProductPlan(
            tuple(edge.action for edge in prefix),
            loop,
            entry.prefix_ms,
            lap_ms,
            cost_ms,
            min(plan.bound_ms, cost_ms),
        )


def _least_cycles(loops: Loops, nodes: np.ndarray) -> Iterator[tuple[int, int]]:
    """Some nodes, each with a lower bound for the cost of cycles through it."""
    if not loops.is_exact:
        yield from ((node, loops.bound_ms) for node in nodes.tolist())
        return
    for start in range(0, len(nodes), loops.batch_size):
        batch = nodes[start : start + loops.batch_size]
        yield from zip(batch.tolist(), loops.costs(batch).tolist(), strict=True)
