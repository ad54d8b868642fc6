"""Judges whether a plan will be late for time bounds that another plan keeps.

1. When an action has begun, the rest of the plan is compared with the limits of the task, with the
   present clocks and flight times, from the place left last. Other plans begin here and now.
2. While an action is under way it may take longer than planned: a flight as long as it has taken,
   and what is left from here; anything else at least as long as it has taken. Half of the margin
   that plans keep is left for the change to another plan.
3. Another plan is better if it keeps the most important line that will be late, and drops no line
   that is more important. In it, a skill that is begun again takes as long as it has taken.
4. A better plan is flown as it was found, without another search: that might find it gone.
5. A better plan that goes on with the action under way does not interrupt it. It is judged instead
   of the present plan from then on; when the action ends, rule 1 applies.
6. If no plan is better, the plan goes on, since it may still be in time. Nobody asks again about
   the same action, unless another line will be late, or one has no time left.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from dataclasses import replace

from companion.acting.flight import Flight
from companion.acting.replanning.replanner import COMPARED, BetterPlan, Replanner
from companion.mission.facts import HERE
from companion.planning.domain import Action, is_one_flight
from companion.planning.en_route import AT_HERE
from companion.planning.lasso import ChosenPlan, Lasso, Letter, Problem
from companion.planning.optional_lines import without_lines
from companion.planning.planner import Planner
from companion.planning.skill_trials import OverdueSkill
from companion.planning.time_check import LateLine, late_lines

CHANGE_S = 0.5
"""What the change to another plan may cost, after the search for it."""


class LatePlans:
    """Compares the rest of the plan with others.

    Attributes:
        are_possible: whether the task has time bounds.

    Args:
        planner: knows the lines that may be dropped, and flight times.
        flight: knows the task, and the progress of the plan.
        replanner: searches for other plans.
    """

    def __init__(self, planner: Planner, flight: Flight, replanner: Replanner) -> None:
        self._planner, self._flight, self._replanner = planner, flight, replanner
        self.are_possible = planner.mission.is_timed
        self._judged = frozenset[tuple[str, bool]]()
        self._instead: ChosenPlan | None = None

    def from_the_beginning(self, lasso: Lasso) -> BetterPlan | None:
        """A better plan, if the rest of a plan whose next action has just begun will be late."""
        self._judged, self._instead = frozenset(), None
        self._replanner.follow_map()
        task = self._flight.task
        problem, _ = without_lines(task.lines.dropped, *task.problem())
        rest = self._as_flown(problem, lasso.rest(self._flight.progress.completed))
        late = tuple(late_lines(problem, rest))
        new = self._better(late, *task.problem(is_interrupted=True)) if late else None
        return None if new is None or self._is_rest_of(lasso, new.plan.lasso) else new

    def _is_rest_of(self, lasso: Lasso, new: Lasso) -> bool:
        """Whether a plan from here is the rest of the present one, the action under way first."""
        completed = self._flight.progress.completed
        _, *others = new.names(COMPARED)
        goes_on = _first(new).from_anywhere == _first(lasso.rest(completed)).from_anywhere
        return goes_on and others == lasso.names(COMPARED, completed)[1:]

    def under_way(self, lasso: Lasso, elapsed_s: float) -> BetterPlan | None:
        """A better plan, if the present one will be late because the action under way takes longer
        than planned; None also if the better plan goes on with this action.

        Args:
            lasso: the plan.
            elapsed_s: how long the action has taken.
        """
        task, running = self._flight.task, self._flight.task.running
        takes_ms = None if running is None else self._takes_ms(running, elapsed_s)
        if running is None or takes_ms is None or takes_ms <= running.cost_ms:
            return None
        self._replanner.follow_map()
        rest, dropped = lasso.rest(self._flight.progress.completed), task.lines.dropped
        if self._instead is not None:
            rest, dropped = self._instead.lasso, frozenset(self._instead.lines_dropped)
        problem, _ = without_lines(dropped, *task.problem())
        flown = _with_first(self._as_flown(problem, rest), takes_ms)
        late = tuple(late_lines(problem, flown, is_watched=True))
        judged = frozenset((each.line, each.is_over) for each in late)
        if judged <= self._judged:
            return None
        self._judged |= judged
        if not is_one_flight(running.execute):
            task.note_overdue(OverdueSkill(running.from_anywhere, takes_ms))
        new = self._soon_better(late)
        if new is not None and _first(new.plan.lasso).from_anywhere != running.from_anywhere:
            return new
        if new is not None:
            self._instead, self._judged = new.plan, frozenset()
        task.forget_overdue()
        return None

    def _as_flown(self, problem: Problem, rest: Lasso) -> Lasso:
        """The rest of a plan with the present costs, from the action under way on."""
        task = self._flight.task
        return as_flown_now(problem, rest, task.running if AT_HERE in task.facts else None)

    def _takes_ms(self, running: Action, elapsed_s: float) -> int | None:
        """How long an action takes at least; None for a charge, and for a flight without a route.

        What a charge takes depends on the charge, and it is not interrupted.
        """
        left_s = 0.0
        if is_one_flight(running.execute) and running.destination is not None:
            left_s = self._planner.actions.flight_time(HERE, running.destination)
        is_known = math.isfinite(left_s) and running.charger is None
        return round(1000 * (elapsed_s + left_s)) if is_known else None

    def _soon_better(self, late: Sequence[LateLine]) -> BetterPlan | None:
        """A better plan that is still in time when the vehicle changes to it."""
        begun_s = self._flight.now_s
        problem, histories = self._flight.task.problem(is_interrupted=True)
        new = self._better(late, problem, histories)
        if new is None:
            return None
        change_ms = round(1000 * (self._flight.now_s - begun_s + CHANGE_S))
        kept, _ = without_lines(new.plan.lines_dropped, problem)
        clocks = tuple(ms if ms is None else ms + change_ms for ms in kept.clocks_ms)
        flown = replace(kept, clocks_ms=clocks)
        return None if any(late_lines(flown, new.plan.lasso)) else new

    def _better(
        self, late: Sequence[LateLine], problem: Problem, histories: Sequence[Sequence[Letter]]
    ) -> BetterPlan | None:
        """The plan for a problem, if it keeps more important lines than one with late lines."""
        dropped = self._planner.solver.lines_to_drop(problem)
        names = [each.line for each in dropped]
        if not self._keeps_more({each.line for each in late}, names):
            return None
        new = self._replanner.search(*without_lines(names, problem, histories))
        if not isinstance(new, Lasso):
            return None
        return BetterPlan(late[0].text, ChosenPlan(new, dropped), problem)

    def _keeps_more(self, late: Collection[str], dropped: Collection[str]) -> bool:
        """Whether lines are dropped only for more important ones that would be late."""
        ranks = {line: rank for rank, line in enumerate(self._planner.mission.optional)}
        first = min(ranks.get(line, -1) for line in late)
        return all(ranks[line] > first for line in set(dropped) - self._flight.task.lines.dropped)


def as_flown_now(problem: Problem, lasso: Lasso, begun: Action | None = None) -> Lasso:
    """A plan with the present costs of its actions, charging as far as it says.

    Args:
        problem: contains the actions.
        lasso: the plan.
        begun: a flight under way that began at no place; it keeps the cost computed when it began.

    >>> from companion.planning.domain import WAIT
    >>> rest = Lasso((), (WAIT,))
    >>> as_flown_now(Problem((WAIT,), (), frozenset(), ()), rest).ends_at_rest
    True
    """
    now = {action.name: action for action in problem.actions}
    if begun is not None:
        now[begun.name] = begun

    def flown(action: Action) -> Action:
        level, own = action.charge_to, now.get(action.name, action)
        return own if level is None else replace(own, charge_to=level)

    return Lasso(*(tuple(map(flown, part)) for part in (lasso.prefix, lasso.loop)))


def _first(lasso: Lasso) -> Action:
    return (lasso.prefix or lasso.loop)[0]


def _with_first(lasso: Lasso, takes_ms: int) -> Lasso:
    """A plan whose first action takes this time; in later laps it does not."""
    _, *others = lasso.prefix or lasso.loop
    return Lasso((replace(_first(lasso), cost_ms=takes_ms), *others), lasso.loop)
