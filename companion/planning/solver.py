"""Answers to planning problems: checked plans, reasons, and which lines of a task can be kept.

Every plan passes the independent check. Before a flight there is time for the best plan; in flight
`replan` gives the first one that is found, and no search takes more than the effort of a flight.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, replace

from companion.errors import CompanionError, RequestError, SearchLimit
from companion.mission.model import Mission
from companion.planning import optional_lines
from companion.planning.builtin.product import Product
from companion.planning.builtin.search import Search
from companion.planning.check import fault
from companion.planning.domain import Action
from companion.planning.effort import BEFORE_FLIGHT, IN_FLIGHT, Effort
from companion.planning.energy.known_loops import KnownLoops
from companion.planning.energy.ready_levels import is_cautious, without_ready
from companion.planning.energy.search import BatterySearch
from companion.planning.energy.shortage import STRANDED, is_stranded, shortages
from companion.planning.energy_check import energy_fault
from companion.planning.explain import Explanation, NoPlan, WorldModel, why_no_plan, world_of
from companion.planning.lasso import DroppedLine, Lasso, Letter, Problem, Solution
from companion.planning.objective import Objective
from companion.planning.readiness import most_kept, ready_lines, ruled_out, too_far
from companion.planning.time_check import time_fault
from companion.planning.timed.known_laps import KnownLaps
from companion.planning.timed.lateness import NO_LIMIT_MS, late_bounds, with_limit
from companion.planning.timed.search import TimedSearch

NO_PROOF = "none was found, which is no proof; leave a line out of ready, or move its place"


@dataclass(frozen=True, slots=True)
class SolverMemory:
    """Results of earlier searches. They are tried first, and so decide between equals.

    Attributes:
        loops: loops on a battery.
        laps: laps that keep time bounds.
    """

    loops: KnownLoops
    laps: KnownLaps


class Solver:
    """Solves the problems of one mission with the built-in search.

    Args:
        mission: gives what its problems do not contain.
        actions: the actions with which every problem begins.
    """

    def __init__(self, mission: Mission, actions: Sequence[Action]) -> None:
        self.mission = mission
        self._search = Search(actions)
        self._battery = BatterySearch(self._search)
        self._timed = TimedSearch(self._battery)
        self._ready = ready_lines(mission)

    def take_actions(self, actions: Sequence[Action]) -> None:
        """From now on every problem begins with these actions, which have new costs."""
        self._search.keep(actions)
        self._timed.costs_have_changed()

    @property
    def memory(self) -> SolverMemory:
        """The results of earlier searches."""
        return SolverMemory(self._battery.loops.copied(), self._timed.known.copied())

    def recall(self, memory: SolverMemory) -> None:
        """Sets the results of earlier searches; all others are forgotten."""
        self._battery.loops, self._timed.known = memory.loops.copied(), memory.laps.copied()

    def solutions(
        self,
        problem: Problem,
        histories: Sequence[Sequence[Letter]],
        objective: Objective = Objective.LAP,
    ) -> Iterator[Solution]:
        """Yields checked solutions, each better than the one before; the last one is the best
        known.

        Args:
            problem: the problem, with the state to plan from.
            histories: per conjunct, the letters that it has read.

        Raises:
            NoPlan: there is no plan; its `explanation` says why.
            SearchLimit: the search was given up.
            CompanionError: an objective other than the lap, for a problem with energy or time
                bounds.
        """
        found = False
        for solution in self._checked(problem, histories, objective, BEFORE_FLIGHT):
            found = True
            yield solution
        if not found:
            world = self._world_of(problem)
            raise NoPlan(
                why_no_plan(problem, self.is_solvable, world, self._shortages, self._late_bounds)
            )

    def solve(
        self,
        problem: Problem,
        histories: Sequence[Sequence[Letter]],
        objective: Objective = Objective.LAP,
    ) -> Solution:
        """The best solution that is found. Raises as `solutions` does."""
        *_, best = self.solutions(problem, histories, objective)
        return best

    def replan(self, problem: Problem, histories: Sequence[Sequence[Letter]]) -> Lasso | None:
        """The first lasso that is found, because in flight an answer is needed at once.

        What ready lines keep of the battery may be used up until a loop is reached. Returns None if
        there is no lasso; `explain_soon` says why.

        Raises:
            SearchLimit: the search was given up.
        """
        limit = None
        for asked in _or_less(problem):
            try:
                first = next(self._checked(asked, histories, Objective.LAP, IN_FLIGHT), None)
            except SearchLimit as reached:
                limit = limit or reached
                continue
            if first is not None:
                return first.lasso
        if limit is not None:
            raise limit
        return None

    def _world_of(self, problem: Problem) -> WorldModel:
        return world_of(self.mission, problem, ruled_out(problem))

    def explain_soon(self, problem: Problem) -> Explanation:
        """Why there is no plan, as far as searches in flight can tell."""
        return why_no_plan(
            problem,
            self._is_solvable_soon,
            world=self._world_of(problem),
            shortages=self._is_short_soon,
            late=self._is_late_soon,
        )

    def _checked(
        self,
        problem: Problem,
        histories: Sequence[Sequence[Letter]],
        objective: Objective,
        effort: Effort,
    ) -> Iterator[Solution]:
        for solution in self._found(problem, objective, effort):
            wrong = fault(problem, solution.lasso, histories)
            if wrong is None and problem.energy is not None:
                wrong = energy_fault(problem, solution.lasso)
            if wrong is None and problem.clocks_ms:
                wrong = time_fault(problem, solution.lasso)
            if wrong is not None:
                text = f"the planner made a wrong plan, {solution.lasso}: {wrong}"
                raise CompanionError(text)
            yield solution

    def _found(self, problem: Problem, objective: Objective, effort: Effort) -> Iterator[Solution]:
        found, is_proved = False, not is_cautious(problem)
        for solution in self._searched(problem, objective, effort):
            found = True
            is_best = is_proved or solution.lasso.ends_at_rest
            yield solution if is_best else replace(solution, bound_ms=0)
        if not found and not is_proved:
            raise SearchLimit("one level that docks keep for lines to be ready", NO_PROOF)

    def _searched(
        self, problem: Problem, objective: Objective, effort: Effort
    ) -> Iterator[Solution]:
        if objective is Objective.LAP:
            return self._timed.solutions(problem, effort)
        if problem.energy is not None or problem.clocks_ms:
            why, kept = "with a battery", "its reserve"
            if problem.energy is None:
                why, kept = "with bounds in time", "them"
            raise RequestError(
                f"the objective {objective.value} is not for missions {why}: plans that "
                f"keep {kept} are those of the shortest lap; leave the objective out"
            )
        return self._search.solutions(problem, objective, effort)

    def kept(
        self, problem: Problem, histories: optional_lines.Histories
    ) -> tuple[Problem, list[Sequence[Letter]], tuple[DroppedLine, ...]]:
        """The problem with only the lines of the task that a plan can keep, before a flight.

        Args:
            problem: the problem with all lines.
            histories: per conjunct, the letters that it has read.

        Returns:
            The problem, the histories of its conjuncts, and the lines that are dropped.
        """
        dropped = optional_lines.select(problem, self.mission.optional, self.is_solvable)
        names = [each.line for each in dropped]
        return *optional_lines.without_lines(names, problem, histories), dropped

    def why_dropped(
        self, problem: Problem, dropped: Sequence[DroppedLine], line: str
    ) -> Explanation:
        """Why a plan that keeps as many lines as it can cannot keep one more.

        Args:
            problem: the problem with all lines.
            dropped: the lines that the plan does not keep.
            line: one of them.
        """
        left_out = [each.line for each in dropped if each.line != line]
        asked, _ = optional_lines.without_lines(left_out, problem)
        world = self._world_of(asked)
        return why_no_plan(asked, self.is_solvable, world, late=self._late_bounds)

    def lines_to_drop(self, problem: Problem) -> tuple[DroppedLine, ...]:
        """The lines to drop in flight."""
        return optional_lines.select(problem, self.mission.optional, self._is_solvable_soon)

    def line_to_take_up(self, problem: Problem, dropped: Collection[str]) -> str | None:
        """The most important dropped line that can be kept now; None if there is none."""
        optional = self.mission.optional
        return optional_lines.line_to_take_up(problem, optional, dropped, self._is_solvable_soon)

    def product(self, problem: Problem) -> Product:
        """The product in which a problem's lassos are searched.

        Raises:
            SearchLimit: the product has too many states.
        """
        return self._search.product(problem)

    def is_solvable(self, problem: Problem, effort: Effort = BEFORE_FLIGHT) -> bool | None:
        """Whether there is a plan; None if the search reaches its limit."""
        found = self._timed.is_solvable(problem, effort)
        return None if found is False and is_cautious(problem) else found

    def _is_solvable_soon(self, problem: Problem) -> bool | None:
        answer: bool | None = False
        for asked in _or_less(problem):
            if found := self.is_solvable(asked, IN_FLIGHT):
                return True
            answer = None if found is None else answer
        return answer

    def _is_short_soon(self, problem: Problem) -> tuple[str, ...]:
        """States that the charge is the reason, if it is, but not which charge would be enough."""
        energy = problem.energy
        if energy is None or not self._is_solvable_soon(replace(problem, energy=None)):
            return ()
        if is_stranded(problem):
            return (STRANDED,)
        now = math.floor(energy.percents[max(0, energy.level - energy.borrowed)])
        return (f"the charge, {now} %, is too little",)

    def _is_late_soon(self, problem: Problem) -> tuple[str, ...]:
        """The time bounds without which there would be a plan, but not the limits that could be
        kept.
        """
        late = tuple(
            f"{conjunct.text} cannot be kept in time from here"
            for number, conjunct in enumerate(problem.conjuncts)
            if conjunct.bound is not None
            and self._is_solvable_soon(with_limit(problem, number, NO_LIMIT_MS))
        )
        return *late, *too_far(self._ready, problem)

    def _shortages(self, problem: Problem) -> tuple[str, ...]:
        short = shortages(self._battery, problem, BEFORE_FLIGHT)
        if problem.energy is None or not problem.energy.ready:
            return short
        is_why = self.is_solvable(without_ready(problem))
        return (*short, most_kept(self._ready, problem.energy)) if is_why else short

    def _late_bounds(self, problem: Problem) -> tuple[str, ...]:
        is_bounded = any(conjunct.bound for conjunct in problem.conjuncts)
        late = late_bounds(self._timed, problem, BEFORE_FLIGHT) if is_bounded else ()
        return *late, *too_far(self._ready, problem)


def _or_less(problem: Problem) -> Iterator[Problem]:
    """A problem; with a battery, then variants of it that keep less until their loop.

    The variants first keep nothing for ready lines, then not all of the reserve.
    """
    yield problem
    energy = problem.energy
    if energy is None:
        return
    if energy.ready:
        energy = replace(energy, is_short=True)
        yield replace(problem, energy=energy)
    if borrowed := energy.borrowable:
        energy = replace(energy, level=energy.level + borrowed, borrowed=borrowed, borrowable=0)
        yield replace(problem, energy=energy)
