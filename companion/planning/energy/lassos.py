"""The lassos of one product that the battery lasts for.

1. A loop either rests, which means to land, or charges (`charging_loops.py`). A loop that was found
   before is not searched again as long as it is the best one (`known_loops.py`).
2. The path into it uses the present charge, and charges if it needs more (`approach.py`). In flight
   the loop is entered where no part of it waits for ever (`fair_approach.py`).
3. Each position keeps its floor: the reserve, and the energy to land at a safe place; and the
   levels of ready lines (`ready_levels.py`).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components

from companion.planning.domain import WAIT, Action
from companion.planning.energy.approach import ApproachGoal, LoopApproach, approach, quickest_paths
from companion.planning.energy.charged_actions import charged
from companion.planning.energy.charging_loops import ChargingLoop, best_loops
from companion.planning.energy.energy_product import NEVER, EnergyProduct
from companion.planning.energy.fair_approach import FairEntry, fairest
from companion.planning.energy.known_loops import KnownLoops
from companion.planning.lasso import Lasso, Solution
from companion.planning.objective import Objective

ENGINE = "built-in, energy"


class EnergyLassos:
    """Looks for lassos in one product.

    Args:
        graph: the product.
        known: loops that were found before; new ones are added.
        proves: whether there is time to find the shortest laps, and to prove them.
    """

    def __init__(self, graph: EnergyProduct, known: KnownLoops, proves: bool) -> None:
        self._graph, self._known, self._proves = graph, known, proves

    def solutions(self, components: Sequence[NDArray[np.intp]]) -> Iterator[Solution]:
        """A good lasso, and the best one if that is requested; none if there is none.

        Args:
            components: the nodes of each strong component with a loop that meets every mark.
        """
        if (rest := self._resting()) is not None:
            yield rest  # nothing is shorter
            return
        loops: list[ChargingLoop] = []
        is_complete = True
        for nodes in components:
            if (found := self._known.of(self._graph, nodes)) is None:
                loops += self._searched(nodes)
            else:
                loops += found.loops
                is_complete = is_complete and found.is_complete
        solution = self._entered(loops)
        if solution is None and not is_complete:
            loops = [loop for each in components for loop in self._searched(each)]
            solution = self._entered(loops)
        if solution is None:
            return
        yield solution
        if self._proves and not all(loop.bound_ms for loop in loops):
            proved = [loop for each in components for loop in self._searched(each, is_proved=True)]
            better = self._entered(proved)
            if better is not None and better.cost_ms <= solution.cost_ms:
                yield better

    def _searched(self, nodes: NDArray[np.intp], is_proved: bool = False) -> list[ChargingLoop]:
        loops = list(best_loops(self._graph, nodes, is_proved))
        self._known.keep(self._graph, nodes, loops)
        return loops

    # -- rest --------------------------------------------------------------------------------------

    def _resting(self) -> Solution | None:
        """The quickest path to where the vehicle may rest for ever."""
        path = self._approach(self._rests())
        if path is None:
            return None
        lasso = Lasso(tuple(self._prefix(path)), (WAIT,))
        return Solution(lasso, Objective.LAP, WAIT.cost_ms, WAIT.cost_ms, ENGINE)

    def _rests(self) -> dict[int, int]:
        """For each node from which rest for ever is accepted, the level required to land."""
        graph, product = self._graph, self._graph.product
        waits = np.flatnonzero([action is WAIT for action in graph.actions])
        before, after = graph.sources[waits], product.ends[waits]
        shape = product.nodes, product.nodes
        resting = csr_array((np.ones(len(waits)), (before, after)), shape=shape)
        count, component = connected_components(resting, connection="strong")
        marks, is_cycle = [0] * count, np.zeros(count, np.bool_)
        is_cycle[component[before[component[before] == component[after]]]] = True
        for node, own in enumerate(component.tolist()):
            marks[own] |= product.marks[node]
        accepted = np.array([met == product.all_marks for met in marks], np.bool_) & is_cycle
        pending = np.flatnonzero(accepted[component]).tolist()
        into: dict[int, list[int]] = {}
        for a, b in zip(before.tolist(), after.tolist(), strict=True):
            into.setdefault(b, []).append(a)
        found: dict[int, int] = {}
        while pending:
            node = pending.pop()
            required = graph.energy.rests.get(graph.places[node])
            if node not in found and required is not None:
                found[node] = required
                pending += into.get(node, [])  # another step of rest makes the same word
        return found

    # -- the path into a loop ----------------------------------------------------------------------

    def _entered(self, loops: Sequence[ChargingLoop]) -> Solution | None:
        """The shortest of some loops that can be reached, with the best path into it."""
        best: tuple[FairEntry, ChargingLoop] | None = None
        for loop in sorted(loops, key=lambda loop: loop.cost_ms):
            if best is not None and loop.cost_ms > best[1].cost_ms:
                break
            entry = self._entry(loop)
            if entry is not None and (best is None or entry.rank < best[0].rank):
                best = entry, loop
        if best is None:
            return None
        bound_ms = min(loop.bound_ms for loop in loops)
        return self._solution(*best, bound_ms // self._graph.product.max_laps)

    def _entry(self, loop: ChargingLoop) -> FairEntry | None:
        """Where a loop is entered; None if it cannot be reached."""
        graph = self._graph
        goals = [
            ApproachGoal(graph.start(edge), needed if self._may_enter(level) else NEVER)
            for edge, needed, level in zip(loop.edges, loop.required, loop.levels, strict=True)
        ]
        paths = quickest_paths(graph.graph, graph.product.initial, graph.energy.level, goals)
        lap = tuple(map(self._action, loop.edges, loop.levels))
        return fairest(
            graph.product,
            [action.cost_ms for action in lap],
            [graph.end(edge) for edge in loop.edges],
            (
                (place, path, [action.cost_ms for action in self._prefix(path)])
                for place, path in paths
            ),
        )

    def _may_enter(self, level: int | None) -> bool:
        """Whether a loop may be entered before this edge, which may charge to a level.

        A path that arrives with less would charge at the same dock just before.
        """
        return level is None or not self._graph.energy.is_short

    def _approach(self, required: dict[int, int]) -> LoopApproach | None:
        level, starts = self._graph.energy.level, self._graph.product.initial
        return approach(self._graph.graph, starts, level, required) if required else None

    def _solution(self, entry: FairEntry, loop: ChargingLoop, bound_ms: int) -> Solution:
        begin = entry.place
        edges = loop.edges[begin:] + loop.edges[:begin]
        levels = loop.levels[begin:] + loop.levels[:begin]
        lap = tuple(map(self._action, edges, levels))
        lasso = Lasso(tuple(self._prefix(entry.path)), lap)
        return Solution(lasso, Objective.LAP, loop.cost_ms, bound_ms, ENGINE)

    def _prefix(self, path: LoopApproach) -> Iterator[Action]:
        level = self._graph.energy.level
        for step in path.steps:
            edge = self._graph.edge(step.node, step.number, step.departure is not None)
            yield self._action(edge, step.departure, level)
            drained = level - int(self._graph.drains[edge])
            level = drained if step.departure is None else step.departure

    def _action(self, edge: int, departure: int | None, arrival: int | None = None) -> Action:
        """The action of an edge that charges to a level, from the arrival level or the floor."""
        action = self._graph.action(edge, in_loop=arrival is None)
        if departure is None:
            return action
        return charged(action, departure, arrival, self._graph.energy.percents)
