"""Finds good laps over many sites that keep bounds, by changing the stops of a lap.

A lap is a closed list of stops, which are nodes that meet a mark or restart a clock, with the
quickest path from each to the next. A change moves, reverses, inserts or removes stops. It is kept
if it makes the lap shorter or less late, and now and then if it does not (simulated annealing). The
price of lateness rises as long as no lap in time is found. The random numbers have a seed, so equal
problems have equal laps.

The result proves nothing: `laps.py` decides whether it is a lap.

Source: Kirkpatrick, Gelatt and Vecchi, Optimization by simulated annealing, 1983; penalties as in
Cordeau, Laporte and Mercier, A unified tabu search heuristic for vehicle routing, 2001.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra

from companion.ltl.time_bounds import Revisit
from companion.planning.builtin.costs import UNREACHABLE_MS
from companion.planning.effort import DIJKSTRA_STEP_US
from companion.planning.timed.component import TimedComponent
from companion.planning.timed.timed_product import TimedProduct
from companion.planning.timed.timed_step import TimedStep
from companion.slices import spent

MOST_STOPS = 80
MOST_NODES = 2000
_MOST_MOVED = 3
ROUNDS = 8
"""Each round begins with the best lap of the one before, at a high temperature again."""
_WARM, _WARM_IN_TIME, _COLD = 0.3, 0.05, 0.002
"""Shares of a lap by which a change may make it worse, at first and at the end."""
_REVIEWED = 100
"""Number of changes after which the price of lateness is reviewed."""
_DEARER, _LEAST_PRICE, _MOST_PRICE = 1.3, 0.1, 5.0
_DRAWN = 1000
_STOP_US, _CHANGE_US = 0.4, 4.0


class _Lap(NamedTuple):
    """The stops, the time to fly along them, and the total lateness of all clocks."""

    stops: list[int]
    cost_ms: int
    late_ms: int


class LapImprovement:
    """The stops of one component, and the paths between them.

    Attributes:
        is_possible: whether the stops are few enough and reach each other.

    Args:
        graph: the product.
        part: the component.
    """

    def __init__(self, graph: TimedProduct, part: TimedComponent) -> None:
        self._graph, self._part = graph, part
        revisits = [c for c, bound in enumerate(graph.bounds) if isinstance(bound, Revisit)]
        inside = set(part.nodes.tolist())
        goals = {
            clock: sorted(inside.intersection(graph.goals(clock).tolist())) for clock in revisits
        }
        free = [
            targets for mark, targets in enumerate(part.targets_of) if not part.free >> mark & 1
        ]
        self.stops = sorted(set().union(*free, *goals.values()))
        number = {node: i for i, node in enumerate(self.stops)}
        self._limits_ms = [graph.limits_ms[clock] for clock in revisits]
        self._clocks: list[list[int]] = [[] for _ in self.stops]
        for own, clock in enumerate(revisits):
            for node in goals[clock]:
                self._clocks[number[node]].append(own)
        self._needs: list[list[int]] = [[] for _ in self.stops]  # marks and clocks that it meets
        needed = [*free, *map(frozenset, goals.values())]
        for need, nodes in enumerate(needed):
            for node in nodes:
                self._needs[number[node]].append(need)
        self._count = len(needed)
        self._bounded = [i for i, clocks in enumerate(self._clocks) if clocks]
        self.is_possible = len(self.stops) <= MOST_STOPS and len(inside) <= MOST_NODES
        if self.is_possible:
            self._find_paths()
            self.is_possible = bool((self._between < UNREACHABLE_MS).all())

    def _find_paths(self) -> None:
        """Finds the quickest paths between all stops."""
        nodes = self._part.nodes.tolist()
        self._number = number = {node: i for i, node in enumerate(nodes)}
        self._steps: dict[tuple[int, int], TimedStep] = {}
        for node in nodes:
            for step, _ in self._part.steps(self._graph.product.state_of[node]):
                key = number[node], number[step.node]
                if key not in self._steps or step.duration_ms < self._steps[key].duration_ms:
                    self._steps[key] = step
        rows, columns = np.array([*self._steps], np.int64).T
        costs = np.array([step.duration_ms for step in self._steps.values()], float)
        matrix = csr_array((costs, (rows, columns)), shape=(len(nodes), len(nodes)))
        at = [number[node] for node in self.stops]
        spent(DIJKSTRA_STEP_US * len(at) * (len(costs) + 30 * len(nodes)))
        found, self._before = dijkstra(matrix, indices=at, return_predecessors=True)
        self._between = np.where(np.isfinite(found), found, UNREACHABLE_MS)[:, at].astype(np.int64)
        self._paths_ms = self._between.tolist()

    def best(self, begin: Sequence[int], changes: int) -> list[TimedStep] | None:
        """The steps of the shortest lap in time that is found; None if none is.

        Args:
            begin: nodes in the order in which they are passed; nodes that are not stops are
                ignored.
            changes: number of changes to try.
        """
        chance, number = _shares(), {node: i for i, node in enumerate(self.stops)}
        stops = [number[node] for node in begin if node in number]
        met = {need for stop in stops for need in self._needs[stop]}
        for stop, needs in enumerate(self._needs):
            if not met.issuperset(needs):
                stops.append(stop)
                met.update(needs)
        if len(stops) < 2:
            return None
        best = _Lap(stops, *self._flown(stops))
        price = 1.0
        for _ in range(ROUNDS):
            best, price = self._cooled(best, price, changes // ROUNDS, chance)
        return None if best.late_ms else self._lap(best.stops)

    def _cooled(
        self, best: _Lap, price: float, changes: int, chance: Iterator[float]
    ) -> tuple[_Lap, float]:
        """The best lap of one round, and the price of lateness at its end."""
        now, in_time = best, 0
        warm = _WARM if best.late_ms else _WARM_IN_TIME
        for change in range(changes):
            heat = now.cost_ms * warm * (_COLD / warm) ** (change / changes)
            stops = self._changed(now.stops, chance)
            if stops is not None:
                lap = _Lap(stops, *self._flown(stops))
                worse = lap.cost_ms - now.cost_ms + price * (lap.late_ms - now.late_ms)
                if worse <= 0 or next(chance) < math.exp(-worse / heat):
                    now = lap
                    if (lap.late_ms, lap.cost_ms) < (best.late_ms, best.cost_ms):
                        best = lap
            in_time += not now.late_ms
            if change % _REVIEWED == _REVIEWED - 1:
                dearer = _DEARER if in_time < _REVIEWED // 2 else 1 / _DEARER
                price, in_time = min(_MOST_PRICE, max(_LEAST_PRICE, price * dearer)), 0
        return best, price

    def _changed(self, stops: list[int], chance: Iterator[float]) -> list[int] | None:
        """A lap with one change; None if the change is impossible."""
        size = len(stops)
        kind = int(8 * next(chance))
        first = int(size * next(chance))
        if kind == 0 and self._bounded:  # one more visit
            stop = self._bounded[int(len(self._bounded) * next(chance))]
            other = [*stops[:first], stop, *stops[first:]]
        elif kind == 1:  # one less
            other = stops[:first] + stops[first + 1 :]
            met = {need for stop in other for need in self._needs[stop]}
            if len(met) < self._count:
                return None
        elif kind <= 4:  # a part is turned round
            last = int(size * next(chance))
            if abs(last - first) < 2:
                return None
            first, last = min(first, last), max(first, last)
            other = stops[:first] + stops[first:last][::-1] + stops[last:]
        else:  # a part is moved
            part = stops[first : first + 1 + int(_MOST_MOVED * next(chance))]
            rest = stops[:first] + stops[first + len(part) :]
            place = int((len(rest) + 1) * next(chance))
            other = rest[:place] + (part if kind == 5 else part[::-1]) + rest[place:]
        spent(_CHANGE_US)
        is_same = any(a == b for a, b in zip(other, other[1:] + other[:1], strict=True))
        return None if is_same or len(other) < 2 else other

    def _flown(self, stops: list[int]) -> tuple[int, int]:
        """The time of a lap, and the total lateness of its clocks."""
        paths_ms, clocks, limits_ms = self._paths_ms, self._clocks, self._limits_ms
        first: list[int | None] = [None] * len(limits_ms)
        last = [0] * len(limits_ms)
        passed_ms = late_ms = 0
        before = stops[-1]
        spent(_STOP_US * len(stops))
        for stop in stops:
            passed_ms += paths_ms[before][stop]
            before = stop
            for clock in clocks[stop]:
                if first[clock] is None:
                    first[clock] = passed_ms
                else:
                    late_ms += max(0, passed_ms - last[clock] - limits_ms[clock])
                last[clock] = passed_ms
        for begun_ms, ended_ms, limit_ms in zip(first, last, limits_ms, strict=True):
            waited_ms = passed_ms - ended_ms + (begun_ms or 0)
            late_ms += max(0, waited_ms - limit_ms)
        return passed_ms, late_ms

    def _lap(self, stops: Sequence[int]) -> list[TimedStep]:
        """The steps along some stops and back to the first one."""
        steps: list[TimedStep] = []
        for begin, end in zip(stops, [*stops[1:], stops[0]], strict=True):
            path: list[TimedStep] = []
            here = self._number[self.stops[end]]
            while here != self._number[self.stops[begin]]:
                before = int(self._before[begin, here])
                path.append(self._steps[before, here])
                here = before
            steps += path[::-1]
        return steps


def _shares() -> Iterator[float]:
    """Random numbers from 0 to 1, the same ones each time."""
    chance = np.random.default_rng(0)
    while True:
        yield from chance.random(_DRAWN).tolist()
