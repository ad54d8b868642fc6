"""The lassos of one problem that keep all bounds, each better than the one before.

If rest is accepted, and all clocks stand still or are reset by it, it is the shortest loop.
Otherwise laps are searched through a few states of which each lap passes one, the shortest laps
first (`lap_search.py`), until one can be entered with the present clocks (`lap_entry.py`). The
order of the search:

1. A known lap. In flight, if it is still possible, nothing else is searched.
2. The tour without bounds, with more visits to what has bounds, changed until it is in time
   (`lap_improvement.py`), or with visits inserted where they are due.
3. All laps. What was found before limits this search.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import reduce
from itertools import groupby, pairwise
from operator import or_

from companion.errors import SearchLimit
from companion.planning.builtin.costs import UNREACHABLE_MS
from companion.planning.builtin.loop_entry import least_lap_ms
from companion.planning.builtin.loops import Loops, loops_of
from companion.planning.builtin.shortest_paths import ShortestPaths
from companion.planning.domain import WAIT, Action
from companion.planning.effort import Effort
from companion.planning.energy.charged_actions import charged
from companion.planning.lasso import Lasso, Problem, Solution
from companion.planning.objective import Objective
from companion.planning.timed.component import TimedComponent
from companion.planning.timed.known_laps import KnownLaps, elsewhere
from companion.planning.timed.label_budget import LabelBudget
from companion.planning.timed.lap_entry import LapEntry, LapEntrySearch
from companion.planning.timed.lap_improvement import LapImprovement
from companion.planning.timed.lap_search import LapSearch
from companion.planning.timed.lapless import Lapless
from companion.planning.timed.laps import TimedLap, lap_of, latest_clocks, rest_of
from companion.planning.timed.timed_product import TimedProduct
from companion.planning.timed.timed_step import TimedStep

ENGINE = "built-in, time bounds"
SHARES = 4
"""The budget is divided by this for a search in a given order."""
LABELS_A_CHANGE = 10
"""Trying a change counts as this many labels."""
FEW_MARKS = 3
"""With at most this many marks without a bound, every order is tried anyway."""


class TimedLassos:
    """Searches the lassos of one problem.

    Args:
        problem: a problem with time bounds.
        graph: its product.
        parts: the strong components with a loop that meets every mark.
        effort: the limits of the search.
        known: laps that were found before; new ones are added.
        into: the product for paths into loops.
    """

    def __init__(
        self,
        problem: Problem,
        graph: TimedProduct,
        parts: Sequence[TimedComponent],
        effort: Effort,
        known: KnownLaps,
        into: TimedProduct,
    ) -> None:
        self._problem, self._graph, self._effort = problem, graph, effort
        self._parts = [part for part in parts if not part.is_never_met()]
        self._known = known
        self._tours: dict[int, Loops] = {}
        self._on_laps: set[int] = set()  # a state of each lap that was found
        self._budget = LabelBudget(effort.time_labels)
        self._entries = LapEntrySearch(into, bool(problem.unread), LabelBudget(effort.time_labels))

    def solutions(self) -> Iterator[Solution]:
        """Lassos, each better than the one before.

        Raises:
            SearchLimit: none was found within the budget.
        """
        if not self._parts or not self._entries.can_begin:
            return
        rests = self._rests()
        if rests and (rest := self._entries.into(rests)) is not None:
            yield self._solution(rest, rest.lap.cost_ms)
            return
        best = self._known_entry()
        if best is not None and self._known.are_best:
            yield self._solution(best, 0)
        parts = self._known.lapless.without_proved(self._parts)
        self._parts = [part for part in self._within_reach(parts) if self._can_be_served(part)]
        for found in self._good_laps():
            if best is None or found.lap.cost_ms < best.lap.cost_ms:
                best = found
                yield self._solution(best, 0)
        if best is None and all(map(self._is_lapless, self._parts)):
            untimed_ms = 0  # nobody asks
        else:
            untimed_ms = self._untimed_ms()
        if best is not None and best.lap.cost_ms <= untimed_ms:
            yield self._solution(best, untimed_ms)
            return
        best, bound_ms, limit = self._best_of_all(best)
        if best is not None:
            self._known.are_best = True
            yield self._solution(best, min(max(bound_ms, untimed_ms), best.lap.cost_ms))
        elif limit is not None:
            raise limit

    def _within_reach(self, parts: Sequence[TimedComponent]) -> list[TimedComponent]:
        """The components without those to which no path leads now, whatever laps they have."""
        reached = self._entries.reached()
        return [p for p in parts if reached is None or not reached.isdisjoint(p.states)]

    def _untimed_ms(self) -> int:
        """What laps cost at least without bounds."""
        for part in self._parts:
            self._tours_of(part).improve()
        return min((self._tours_of(part).bound_ms for part in self._parts), default=0)

    def _best_of_all(
        self, best: LapEntry | None
    ) -> tuple[LapEntry | None, int, SearchLimit | None]:
        """Looks at all laps, as far as the budget goes.

        Args:
            best: that is known.

        Returns:
            The best one, what no lap costs less than, and the limit that was reached, if any.
        """
        bound_ms, limit = UNREACHABLE_MS, None
        for part in self._parts:
            if (known := self._lapless_as(part)) is not None:
                limit = limit if known.is_proved else self._budget.limit
                bound_ms = min(bound_ms, known.bound_ms)
                continue
            labels, part_ms, reached, had_best = self._budget.left, UNREACHABLE_MS, None, bool(best)
            for search in self._lap_searches(part):
                below_ms = UNREACHABLE_MS if best is None else best.lap.cost_ms
                try:
                    best = self._first_entered(search, below_ms) or best
                except SearchLimit as at_limit:
                    limit = reached = at_limit
                part_ms = min(part_ms, search.bound_ms)
            bound_ms = min(bound_ms, part_ms)
            if not had_best and self._on_laps.isdisjoint(part.states):
                labels_used = None if reached is None else labels
                self._known.lapless.keep(part, Lapless(labels_used, part_ms))
        return best, bound_ms, limit

    def _lapless_as(self, part: TimedComponent) -> Lapless | None:
        """What is known of a component in which no lap was found with as large a budget."""
        return self._known.lapless.of(part, self._effort.time_labels)

    def _is_lapless(self, part: TimedComponent) -> bool:
        return self._lapless_as(part) is not None

    def _can_be_served(self, part: TimedComponent) -> bool:
        """Whether each mark is met by some lap; False proves that no lap meets all of them."""
        if self._is_lapless(part):
            return True  # this was asked before
        budget = self._budget.share(SHARES)
        for mark in range(len(part.targets_of)):
            is_free = part.free >> mark & 1
            if not is_free and self._has_lap(part.with_marks([mark]), budget) is False:
                self._known.lapless.keep(part, Lapless(None, UNREACHABLE_MS))
                return False
        return True

    def _has_lap(self, part: TimedComponent, budget: LabelBudget) -> bool | None:
        """Whether a component has a lap; None if the search reaches its limit."""
        barred = frozenset[int]()
        for anchor in part.anchors():
            try:
                if next(LapSearch(self._graph, part, anchor, budget, barred).laps(), None):
                    return True
            except SearchLimit:
                return None
            barred |= {anchor}
        return False

    def _lap_searches(self, part: TimedComponent) -> Iterator[LapSearch]:
        """Searches that together find every lap of a component."""
        barred = frozenset[int]()
        for anchor in part.anchors():
            yield LapSearch(self._graph, part, anchor, self._budget, barred)
            barred |= {anchor}

    def _first_entered(self, search: LapSearch, below_ms: int) -> LapEntry | None:
        """The shortest lap that can be entered, with the path into it; None if there is none.

        Raises:
            SearchLimit: the budget is not sufficient.
        """
        for steps in search.laps(below_ms):
            self._on_laps.add(steps[0].end)
            found = self._entered(steps)
            if found is not None:
                return found
        return None

    def _entered(self, steps: Sequence[TimedStep]) -> LapEntry | None:
        """A lap, in the direction that is better to enter; None if it cannot be entered."""
        variants = [self._trimmed(steps), self._backwards(steps)]
        laps = [lap for lap in variants if lap is not None]
        others = [part for part in self._parts if laps and steps[0].end not in part.states]
        laps += elsewhere(laps, self._problem, self._graph, others)
        return self._entries.into(laps) if laps else None

    def _trimmed(self, steps: Sequence[TimedStep]) -> TimedLap | None:
        """A lap with no charge higher than necessary; None if it then breaks a bound."""
        graph, actions = self._graph, self._problem.actions
        if graph.charges is None:
            return lap_of(graph, steps)
        least = [graph.charges.from_least(step, actions[step.action]) for step in steps]
        latest = [clocks[-1] for clocks in latest_clocks(graph, least)]
        return lap_of(graph, graph.charges.trimmed(steps, latest, actions)) or lap_of(graph, steps)

    def _backwards(self, steps: Sequence[TimedStep]) -> TimedLap | None:
        """The lap in the other direction, if it exists and costs the same."""
        if any(step.charge is not None for step in steps):
            return None
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
        """The laps on which the vehicle rests for ever."""
        graph, found = self._graph, []
        for part in self._parts:
            for state in part.states:
                for step, marks in part.steps(state):
                    is_rest = self._problem.actions[step.action] is WAIT and step.end == state
                    if is_rest and marks == part.all and (lap := rest_of(graph, step)):
                        found.append(lap)
        return found

    def _good_laps(self) -> Iterator[LapEntry]:
        """Laps that are likely to be good, with paths into them."""
        in_vain = set[bytes]()  # fingerprints of components without one
        for part in self._parts:
            if self._is_lapless(part) or (in_vain and part.fingerprint in in_vain):
                continue
            if (improved := self._improved(part)) is not None:
                yield improved
                continue
            for search in self._ordered(part):
                try:
                    found = self._first_entered(search, UNREACHABLE_MS)
                except SearchLimit:
                    continue
                if found is not None:
                    yield found
            if len(self._parts) > 1 and self._on_laps.isdisjoint(part.states):
                in_vain.add(part.fingerprint)

    def _improved(self, part: TimedComponent) -> LapEntry | None:
        """The best lap found by changing the tour without bounds."""
        if self._graph.charges is not None or part.all.bit_count() <= FEW_MARKS:
            return None
        improvement = LapImprovement(self._graph, part)
        if not improvement.is_possible:
            return None
        begin = [edge.end for edge in self._tours_of(part).loop_from(improvement.stops[0])]
        steps = improvement.best(begin, self._effort.time_labels // LABELS_A_CHANGE)
        if steps is None or not self._is_accepted(steps):
            return None
        self._on_laps.add(steps[0].end)
        return self._entered(steps)

    def _known_entry(self) -> LapEntry | None:
        """The path into the shortest known lap that can be entered; None if none can."""
        known = self._known.within(self._problem, self._graph, self._parts)
        alike = (list(laps) for _, laps in groupby(known, key=lambda lap: lap.cost_ms))
        entries = map(self._entries.into, alike)
        return next((entry for entry in entries if entry is not None), None)

    def _ordered(self, part: TimedComponent) -> Iterator[LapSearch]:
        """Searches for laps that meet most marks in the shortest tour's order, either way."""
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
        """The loops of a component, ignoring bounds."""
        found = self._tours.get(id(part))
        if found is None:
            paths = ShortestPaths(self._graph.product)
            found = loops_of(self._graph.product, part.nodes, paths, self._effort)
            self._tours[id(part)] = found
        return found

    # -- what is found -----------------------------------------------------------------------------

    def _solution(self, found: LapEntry, bound_ms: int) -> Solution:
        if not found.lap.is_rest:
            self._known.keep(self._problem, found.lap)
        prefix = [self._action(step, in_loop=False) for step in self._entries.trimmed(found)]
        loop = tuple(map(self._action, found.round))
        if loop == (WAIT,):
            while prefix and prefix[-1] is WAIT:  # without its last rest the word is the same
                prefix.pop()
        bound_ms = least_lap_ms(self._graph.product, bound_ms)
        lasso = Lasso(tuple(prefix), loop)
        return Solution(lasso, Objective.LAP, found.lap.cost_ms, bound_ms, ENGINE)

    def _action(self, step: TimedStep, in_loop: bool = True) -> Action:
        action, energy = self._problem.actions[step.action], self._problem.energy
        if step.charge is None or energy is None or action.charger is None:
            return action
        if energy.is_short and not in_loop:
            action = replace(action, charger=action.charger.bare or action.charger)
        needs, leaves = step.charge
        return charged(action, leaves, needs, energy.percents)
