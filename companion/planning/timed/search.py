"""The best lasso that keeps the bounds in time of a task: shortest lap, then shortest prefix.

A bounded line is read by an automaton, without its bound, and by a clock (`timed_product.py`).
Rest, where it is accepted with all clocks still or set by it, is the shortest loop. Else laps are
looked for through few states of which each passes one, the shortest first (`lap_search.py`), until
one can be entered with the clocks as they are (`lap_entry.py`): by generalized acceptance and with
clocks as labels this is exact. It may take long, so there is a budget of labels:

- a lap that was flown before is tried first: in flight nothing else is looked for if it still does;
- then the tour without bounds, with visits to what has bounds put in where they are due;
- then all laps. What is found first bounds what is looked for.

Where the budget ends before a lap is found it is not known whether there is one, and where it ends
after, how far from the shortest it may be.

Whether deadlines of this kind can be kept for ever is PSPACE-complete for one vehicle: Ho and
Ouaknine, The cyclic-routing UAV problem is PSPACE-complete, FoSSaCS 2015.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator, Sequence
from functools import reduce
from itertools import pairwise
from operator import or_

from companion.errors import SearchLimit
from companion.planning.builtin.costs import UNREACHABLE_MS
from companion.planning.builtin.loop_entry import least_lap_ms
from companion.planning.builtin.loops import Loops, loops_of
from companion.planning.builtin.search import Search, accepting_components
from companion.planning.builtin.shortest_paths import ShortestPaths
from companion.planning.domain import WAIT
from companion.planning.effort import Effort
from companion.planning.lasso import Lasso, Problem, Solution
from companion.planning.objective import Objective
from companion.planning.timed.component import TimedComponent
from companion.planning.timed.known_laps import KnownLaps
from companion.planning.timed.label_budget import LabelBudget
from companion.planning.timed.lap_entry import LapEntry, WaysIn
from companion.planning.timed.lap_search import LapSearch
from companion.planning.timed.laps import TimedLap, lap_of
from companion.planning.timed.timed_product import TimedProduct, TimedStep, may_any_run

ENGINE = "built-in, time bounds"
SHARES = 4
"""A search in a given order has this part of the budget."""
FEW_MARKS = 3
"""Of so few that are not bounded every order is tried anyway."""


class TimedSearch:
    """Plans that keep bounds, from any state of one mission.

    Args:
        search: knows the mission's actions and automata.

    Attributes:
        known: laps that were found before.
    """

    def __init__(self, search: Search) -> None:
        self._search = search
        self.known = KnownLaps()

    def costs_have_changed(self) -> None:
        """What was found before may not be the best any more."""
        self.known.are_best = False

    def is_solvable(self, problem: Problem, effort: Effort) -> bool | None:
        """Whether there is a lasso; None if a search reaches its limit."""
        try:
            return next(self.solutions(problem, effort), None) is not None
        except SearchLimit:
            return None

    def solutions(self, problem: Problem, effort: Effort) -> Iterator[Solution]:
        """Lassos, each better than the one before; none if there is none.

        Where a flight is late, what plans keep in hand may be used up.

        Raises:
            SearchLimit: the product has too many states, or the budget ended before any was found.
        """
        if not may_any_run(problem):
            yield from self._search.solutions(problem, Objective.LAP, effort)
            return
        product = self._search.product(problem, effort, min_goals=sys.maxsize)
        components = accepting_components(product)
        if not components:
            return
        has_found, limit = False, None
        for is_late in (False, True) if any(problem.clocks_ms) else (False,):
            graph = TimedProduct(problem, product, is_late)
            if not graph.bounds:
                yield from self._search.solutions(problem, Objective.LAP, effort)
                return
            parts = [TimedComponent(graph, nodes) for nodes in components]
            try:
                lassos = _Lassos(problem, graph, parts, effort, self.known)
                for solution in lassos.solutions():
                    has_found = True
                    self.known.keep(solution.lasso)
                    yield solution
            except SearchLimit as reached:
                limit = limit or reached
            if has_found:
                return
        if limit is not None:
            raise limit


class _Lassos:
    """Looks for the lassos of one problem."""

    def __init__(
        self,
        problem: Problem,
        graph: TimedProduct,
        parts: Sequence[TimedComponent],
        effort: Effort,
        known: KnownLaps,
    ) -> None:
        self._problem, self._graph, self._effort = problem, graph, effort
        self._parts = [part for part in parts if not part.is_never_met()]
        self._known = known
        self._tours: dict[int, Loops] = {}
        self._budget = LabelBudget(effort.time_labels)
        self._ways = WaysIn(graph, bool(problem.unread), LabelBudget(effort.time_labels))

    def solutions(self) -> Iterator[Solution]:
        """Each better than the one before.

        Raises:
            SearchLimit: none was found within the budget.
        """
        if not self._parts or not self._ways.can_begin:
            return
        rests = self._rests()
        if rests and (rest := self._ways.into(rests)) is not None:
            yield self._solution(rest, rest.lap.cost_ms)
            return
        best = self._known_entry()
        if best is not None and self._known.are_best:
            yield self._solution(best, 0)
        self._parts = [part for part in self._parts if self._can_be_served(part)]
        for found in self._good_laps():
            if best is None or found.lap.cost_ms < best.lap.cost_ms:
                best = found
                yield self._solution(best, 0)
        bound_ms, limit = UNREACHABLE_MS, None
        untimed_ms = min((self._tours_of(p).bound_ms for p in self._parts), default=0)
        if best is not None and best.lap.cost_ms <= untimed_ms:
            yield self._solution(best, untimed_ms)
            return
        for search in self._lap_searches():
            below_ms = UNREACHABLE_MS if best is None else best.lap.cost_ms
            try:
                best = self._first_entered(search, below_ms) or best
            except SearchLimit as reached:
                limit = reached
            bound_ms = min(bound_ms, search.bound_ms)
        if best is not None:
            self._known.are_best = True
            yield self._solution(best, min(max(bound_ms, untimed_ms), best.lap.cost_ms))
        elif limit is not None:
            raise limit

    def _can_be_served(self, part: TimedComponent) -> bool:
        """Whether for each mark some lap meets it; False is a proof that none meets all."""
        budget = self._budget.share(SHARES)
        for mark in range(len(part.targets_of)):
            is_free = part.free >> mark & 1
            if not is_free and self._has_lap(part.with_marks([mark]), budget) is False:
                return False
        return True

    def _has_lap(self, part: TimedComponent, budget: LabelBudget) -> bool | None:
        """Whether there is a lap in a component; None if the search reaches its limit."""
        barred = frozenset[int]()
        for anchor in part.anchors():
            try:
                if next(LapSearch(self._graph, part, anchor, budget, barred).laps(), None):
                    return True
            except SearchLimit:
                return None
            barred |= {anchor}
        return False

    def _lap_searches(self) -> Iterator[LapSearch]:
        """Searches that find every lap, one after the other."""
        for part in self._parts:
            barred = frozenset[int]()
            for anchor in part.anchors():
                yield LapSearch(self._graph, part, anchor, self._budget, barred)
                barred |= {anchor}

    def _first_entered(self, search: LapSearch, below_ms: int) -> LapEntry | None:
        """The shortest lap that can be entered, with the way into it; None if there is none.

        Raises:
            SearchLimit: the budget does not suffice.
        """
        for steps in search.laps(below_ms):
            found = self._entered(steps)
            if found is not None:
                return found
        return None

    def _entered(self, steps: Sequence[TimedStep]) -> LapEntry | None:
        """A lap, in the direction in which it is entered better; None if it cannot be."""
        ways = [lap_of(self._graph, steps), self._backwards(steps)]
        laps = [lap for lap in ways if lap is not None]
        return self._ways.into(laps) if laps else None

    def _backwards(self, steps: Sequence[TimedStep]) -> TimedLap | None:
        """A lap in the other direction, if there is one that costs as much."""
        states = [step.end for step in steps[::-1]]
        back: list[TimedStep] = []
        for here, after in pairwise([*states, states[0]]):
            step = next((each for each in self._graph.steps(here) if each.end == after), None)
            if step is None:
                return None
            back.append(step)
        is_as_short = sum(s.cost_ms for s in back) == sum(s.cost_ms for s in steps)
        return lap_of(self._graph, back) if is_as_short and self._is_accepted(back) else None

    def _is_accepted(self, steps: Sequence[TimedStep]) -> bool:
        marks = self._graph.product.marks
        met = reduce(or_, (marks[step.node] for step in steps))
        return met == self._graph.product.all_marks

    # -- laps that are looked for first ------------------------------------------------------------

    def _rests(self) -> list[TimedLap]:
        """Where the vehicle may rest for ever."""
        graph, found = self._graph, []
        for part in self._parts:
            for state in part.states:
                for step, marks in part.steps(state):
                    is_rest = self._problem.actions[step.action] is WAIT and step.end == state
                    if is_rest and marks == part.all and (lap := lap_of(graph, [step])):
                        found.append(lap)
        return found

    def _good_laps(self) -> Iterator[LapEntry]:
        """Laps that are likely to be good, with ways into them."""
        for part in self._parts:
            for search in self._ordered(part):
                try:
                    found = self._first_entered(search, UNREACHABLE_MS)
                except SearchLimit:
                    continue
                if found is not None:
                    yield found

    def _known_entry(self) -> LapEntry | None:
        """The way into the shortest lap that is known and can be entered; None if none can be."""
        known = self._known.within(self._problem, self._graph, self._parts)
        ways = (self._ways.into([lap]) for lap in known)
        return next((way for way in ways if way is not None), None)

    def _ordered(self, part: TimedComponent) -> Iterator[LapSearch]:
        """Searches for laps that meet most marks in the order of the shortest tour, both ways."""
        marks = [mark for mark in range(len(part.targets_of)) if not part.free >> mark & 1]
        if len(marks) <= FEW_MARKS:
            return
        graph, anchor = self._graph, part.anchors()[0]
        at = next(node for node in part.nodes.tolist() if graph.product.state_of[node] == anchor)
        order: dict[int, None] = {}
        for edge in self._tours_of(part).loop_from(at):
            order.update((mark, None) for mark in marks if edge.end in part.targets_of[mark])
        for directed in (list(order), list(order)[::-1]):
            ordered = part.with_marks(directed)
            budget = self._budget.share(SHARES)
            yield LapSearch(graph, ordered, anchor, budget, is_in_order=True)

    def _tours_of(self, part: TimedComponent) -> Loops:
        """The loops of a component without bounds."""
        found = self._tours.get(id(part))
        if found is None:
            paths = ShortestPaths(self._graph.product)
            found = loops_of(self._graph.product, part.nodes, paths, self._effort)
            self._tours[id(part)] = found
        return found

    # -- what is found -----------------------------------------------------------------------------

    def _solution(self, found: LapEntry, bound_ms: int) -> Solution:
        actions = self._problem.actions
        prefix = [actions[step.action] for step in found.prefix]
        loop = tuple(actions[step.action] for step in found.round)
        if loop == (WAIT,):
            while prefix and prefix[-1] is WAIT:  # a step of rest less is the same word
                prefix.pop()
        bound_ms = least_lap_ms(self._graph.product, bound_ms)
        lasso = Lasso(tuple(prefix), loop)
        return Solution(lasso, Objective.LAP, found.lap.cost_ms, bound_ms, ENGINE)
