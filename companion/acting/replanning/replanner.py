"""Plans again in flight, in slices that each fit into a tick; the vehicle holds meanwhile.

1. A plan waits until the routes on the map are known, but not for ever: a map may keep changing.
2. The moves are taken from the map, the lines of the task that can be kept are chosen, and the
   first plan found for them is used. If there is none, the reason is searched for. If facts change
   meanwhile, it starts again. A plan that was found while the one before was flown is used without
   a search, unless something has changed since.
3. It waits for an engine from outside; if that fails, the built-in search is used.
4. Replans for failed skills without a completed skill in between lead nowhere (idle_replans.py).
   After some in a row, the optional lines that need one of these skills are dropped, until an event
   or a belief comes; or all of them, if a line that must hold needs one. If that does not help, or
   there are none, the replanner gives up.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass

from companion.acting.flight import Flight
from companion.acting.replanning.assumptions import FLAPPING_S, Assumptions
from companion.acting.replanning.idle_replans import MAX_IDLE_REPLANS, IdleReplans
from companion.acting.replanning.optional_lines import LED_NOWHERE
from companion.acting.replanning.patience import Patience
from companion.acting.replanning.reachability import Reachability
from companion.errors import NoPlanError, SearchLimit
from companion.flight_events.facts import PlacesCutOff
from companion.flight_events.plans import EngineFailed
from companion.outcomes import Failed
from companion.planning.engine_port import Engine
from companion.planning.explain import Explanation, NoPlan
from companion.planning.lasso import ChosenPlan, DroppedLine, Lasso, Letter, Problem
from companion.planning.optional_lines import without_lines
from companion.planning.planner import Planner
from companion.planning.situation import TaskSituation
from companion.slices import InSlices, Question, spent, wait_a_tick

COMPARED = 1000
"""Plans that agree in so many actions count as equal."""
_ADOPTION_US = 120
"""Time for each action of a plan; so a long plan is adopted in a tick of its own."""
MAP_SETTLES_S = 5.0
"""How long a replan waits for a map that goes on changing while the vehicle holds."""
MAP_HAS_CHANGED = "the map has changed"
"""The reason for a new plan if neither events nor beliefs have changed."""

PlanFailure = NoPlanError | SearchLimit
"""There is no plan, or none was found within the limits of the search; a value here, which the
sortie reports as its failure."""


@dataclass(frozen=True, slots=True)
class BetterPlan:
    """A plan that was found while the present one is flown.

    Attributes:
        reason: why it is better, in words for people.
        plan: the plan.
        problem: what it was found for: the task from here, with the action under way ended.
    """

    reason: str
    plan: ChosenPlan
    problem: Problem


ReplanReason = str | BetterPlan
"""Why a new plan is due, in words for people; or the plan to change to."""


@dataclass(frozen=True, slots=True)
class DueReplan:
    """A plan that is due in flight.

    Attributes:
        reason: why, in words for people.
        since_s: when it became due.
        left_for: why the plan before was left; differs from `reason` if a plan was waited for.
        better: the plan that has been found already, if one has.
    """

    reason: str
    since_s: float
    left_for: str
    better: BetterPlan | None = None


class Replanner:
    """Makes one plan after another.

    Attributes:
        reachability: the moves that the map allows.
        is_explaining: whether there is no plan, and the reason is being searched for.

    Args:
        planner: the mission's planner.
        flight: plans begin at its present state.
        assumptions: learns of beliefs that the map restores.
        patience: learns why there is no plan.
        engine: the planner to use; None for the built-in search, which is also used if an engine
            fails, and to check whether the present plan is still the best one.
        explain: explains why a problem has no plan; None for the planner's own explanation.
    """

    def __init__(
        self,
        planner: Planner,
        flight: Flight,
        assumptions: Assumptions,
        patience: Patience,
        engine: Engine | None = None,
        explain: Callable[[Problem], Explanation] | None = None,
    ) -> None:
        self.reachability = Reachability(planner, flight)
        self.is_explaining = False
        self._planner = planner
        self._flight = flight
        self._assumptions = assumptions
        self._patience = patience
        self._engine = engine
        self._explain = explain or planner.solver.explain_soon
        self._planning: InSlices[ChosenPlan | PlanFailure] | None = None
        self._planned_in: TaskSituation | None = None
        self._idle = IdleReplans(flight)
        self._looked_at: tuple[object, ...] = ()
        self._looked_s = 0.0
        self._looking = Question[bool]()
        self._unchanged: object = None

    def begin(self, reason: ReplanReason, left_for: str | None = None) -> DueReplan:
        """Begins a replan; `left_for` is given if earlier searches for it found no plan."""
        self.abandon()
        wrong = self._assumptions.wrong
        if wrong:  # the world has changed: the plan before did not fail
            self._assumptions.note_replan(wrong)
        else:
            self._idle.count()
        better = reason if isinstance(reason, BetterPlan) else None
        words = reason.reason if isinstance(reason, BetterPlan) else reason
        return DueReplan(words, self._flight.now_s, left_for or words, better)

    def abandon(self) -> None:
        """Ends the search, because nobody waits for its plan any more."""
        self._looking.abandon()
        self.is_explaining = False
        self._planned_in = None
        if self._planning is not None:
            self._planning.abandon()
            self._planning = None

    def start_over(self) -> None:
        """Forgets plans that led nowhere, because the operator wants to continue."""
        self._idle.reset()
        self._flight.task.put_back()

    def step(self, due: DueReplan) -> ChosenPlan | PlanFailure | None:
        """Works for one slice; returns the plan, or why there is none, once that is known."""
        reachability, flight = self.reachability, self._flight
        reachability.search()
        if not reachability.is_known and flight.now_s < due.since_s + MAP_SETTLES_S:
            return None
        if self._has_become_outdated():
            self.abandon()
            self._idle.count()  # flapping facts must not cause endless searches
        if self._planning is None:
            self._planning = InSlices(lambda: self._plan(due.better))
        if not self._planning.step():
            return None
        found = self._planning.result
        self.abandon()
        return found

    def _has_become_outdated(self) -> bool:
        """Whether something has changed that the plan in the making does not consider.

        Each event restarts it at most once a second; the finished plan notices later changes as
        wrong assumptions.
        """
        if self._planned_in is None:
            return False
        now, assumptions = self._flight.task.situation, self._assumptions
        if self._planned_in.is_like(now, but_for=assumptions.flapping | assumptions.unread):
            return False
        assumptions.note_replan(self._planned_in.changed_events(now))
        return True

    def _plan(self, better: BetterPlan | None) -> ChosenPlan | PlanFailure:
        found = self._find(better)
        if isinstance(found, ChosenPlan):
            spent(_ADOPTION_US * (len(found.lasso.prefix) + len(found.lasso.loop)))
        else:
            self._patience.begin(found)
        return found

    def _find(self, better: BetterPlan | None) -> ChosenPlan | PlanFailure:
        flight, planner = self._flight, self._planner
        self.follow_map()
        self._looked_s = flight.now_s
        self._assumptions.forget_restored_beliefs()
        if planner.mission.tree is not None:
            return NoPlanError("no plan: the mission has a tree of its own")
        task, idle = flight.task, self._idle
        is_last = task.lines.dropped == task.lines.optional
        if idle.are_too_many and (is_last or idle.number > MAX_IDLE_REPLANS):
            return NoPlanError(f"no plan: {idle.number} plans in a row led nowhere")
        self._planned_in = task.situation
        self._assumptions.renew()
        if better is not None and not idle.are_too_many and self._is_current(better):
            return better.plan
        self._review_skills()
        problem, histories = task.problem()
        self._looked_at, self._unchanged = _what_decides(problem), None
        dropped = self._lines_to_drop(problem)
        found = self._solve(*without_lines([each.line for each in dropped], problem, histories))
        return ChosenPlan(found, dropped) if isinstance(found, Lasso) else found

    def _is_current(self, better: BetterPlan) -> bool:
        """Whether nothing that decides on plans has changed since this one was found."""
        self._looked_at, self._unchanged = _what_decides(self._flight.task.problem()[0]), None
        return _what_decides(better.problem) == self._looked_at

    def _review_skills(self) -> None:
        """Puts skills aside that failed in vain; forgets about skills what leaves no plan for the
        lines that must hold.
        """
        task = self._flight.task
        if self._idle.are_too_many:
            task.put_aside(self._idle.failed)
        if task.trials.overdue is not None and not self.is_possible:
            task.forget_overdue()
        if task.trials.put_aside and not self.is_possible:
            task.put_back()

    def _lines_to_drop(self, problem: Problem) -> tuple[DroppedLine, ...]:
        """The lines that the next plan drops; all of them if plans led nowhere for another reason
        than a skill that can be put aside.
        """
        planner, task = self._planner, self._flight.task
        if not self._idle.are_too_many:
            return planner.solver.lines_to_drop(problem)
        lines: Collection[str] = planner.mission.optional
        if task.trials.put_aside:
            lines = [each.line for each in planner.solver.lines_to_drop(problem)]
        return tuple(DroppedLine(line, LED_NOWHERE) for line in lines)

    def _solve(
        self, problem: Problem, histories: Sequence[Sequence[Letter]]
    ) -> Lasso | PlanFailure:
        """A plan for the lines that are kept, or why there is none."""
        if self._engine is not None:
            answer = self._ask(self._engine, problem, histories)
            if isinstance(answer, Lasso):
                return answer
            self._flight.report(EngineFailed(answer.reason))
        found = self.search(problem, histories)
        if found is not None:
            return found
        self.is_explaining = True
        return NoPlan(self._explain(problem))

    def _ask(
        self, engine: Engine, problem: Problem, histories: Sequence[Sequence[Letter]]
    ) -> Lasso | Failed:
        """The answer of an engine, which works outside the loop."""
        job = engine.begin(problem, histories, self._flight.now_s)
        try:
            while (answer := job.answer(self._flight.now_s)) is None:
                wait_a_tick()
        finally:
            job.abandon()
        return answer

    def looks_again(self) -> str | None:
        """What has changed since the last search, at least a second ago; None if nothing has."""
        flight = self._flight
        self.reachability.search()
        is_early = flight.now_s - self._looked_s < FLAPPING_S
        now = flight.task.situation, flight.routes.version
        if is_early or not self.reachability.is_known or now == self._unchanged:
            return None
        answered = self._looking.ask(now, self._has_changed)
        if answered is None:
            return None
        if answered.answer:
            return self._assumptions.news or MAP_HAS_CHANGED
        self._unchanged = now
        return None

    def _has_changed(self) -> bool:
        self.follow_map()
        return _what_decides(self._flight.task.problem()[0]) != self._looked_at

    def follow_map(self) -> PlacesCutOff | None:
        """Updates moves and beliefs from the map; returns the beliefs given up, if any."""
        change = self.reachability.follow()
        if change.connected is not None:
            self._assumptions.note_restored_beliefs()
        return change.cut_off

    def plan_now(self) -> Lasso | None:
        """The plan that would be made now for the lines that are kept; None if none is found."""
        return self._plan_without(self._flight.task.lines.dropped)

    @property
    def is_possible(self) -> bool:
        """Whether there is a plan for the lines of the task that are never dropped.

        No plan is made for a mission with a tree written by hand, whatever its task.
        """
        is_planned = self._planner.mission.tree is None
        return is_planned and self._plan_without(self._flight.task.lines.optional) is not None

    @property
    def line_to_take_up(self) -> str | None:
        """The most important dropped line that can be kept now; None if there is none."""
        task = self._flight.task
        return self._planner.solver.line_to_take_up(task.problem()[0], task.lines.dropped)

    def _plan_without(self, lines: Collection[str]) -> Lasso | None:
        found = self.search(*without_lines(lines, *self._flight.task.problem()))
        return found if isinstance(found, Lasso) else None

    def search_confirms(self, lasso: Lasso) -> bool:
        """Plans now, from the place left last; true if that is the rest of the present plan."""
        new = self.plan_now() if self._flight.task.running is not None else None
        return new is not None and self.is_rest_of(lasso, new)

    def is_rest_of(self, lasso: Lasso, new: Lasso) -> bool:
        """Whether a new plan equals the rest of the present one."""
        return new.names(COMPARED) == lasso.names(COMPARED, self._flight.progress.completed)

    def search(
        self, problem: Problem, histories: Sequence[Sequence[Letter]]
    ) -> Lasso | SearchLimit | None:
        """The first plan found, the limit at which the search was given up, or None for no plan."""
        try:
            return self._planner.solver.replan(problem, histories)
        except SearchLimit as limit:
            return limit


def _what_decides(problem: Problem) -> tuple[object, ...]:
    """Everything in a problem that determines whether there is a plan."""
    actions = tuple(action.name for action in problem.actions)
    return actions, problem.facts, problem.withdrawn, problem.automaton_states
