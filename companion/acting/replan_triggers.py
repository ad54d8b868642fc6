"""The reasons for replacing the plan under way: a table of triggers, in the order of a tick.

Each trigger has a guard, which is quick and changes nothing. If the guard holds, the trigger looks
closer: it may read the changed map or search for a plan. It returns in words why a new plan is due.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from companion.acting.charge.energy_watch import EnergyWatch
from companion.acting.flight import Flight
from companion.acting.plan_under_way import PlanUnderWay
from companion.acting.replanning.assumptions import BELIEF_CAME_BACK, Assumptions
from companion.acting.replanning.replanner import Replanner
from companion.planning.energy.mission_energy import MissionEnergy
from companion.planning.lasso import Lasso
from companion.slices import Question, ask_once


@dataclass(frozen=True, slots=True)
class ReplanTrigger:
    """One reason to plan again.

    Attributes:
        name: what has happened.
        guard: says whether to look closer; it is quick and changes nothing.
        reason: looks closer, and returns in words why a new plan is due; None if it is not.
    """

    name: str
    guard: Callable[[ReplanTriggers, PlanUnderWay], bool]
    reason: Callable[[ReplanTriggers, PlanUnderWay], str | None]


class ReplanTriggers:
    """Notices what a plan did not expect.

    Attributes:
        has_used_slice: whether this tick's slice of search went into the question whether the plan
            is still the best one, without an answer.

    Args:
        flight: knows the present facts and the progress of the plan.
        assumptions: the assumptions of the plan.
        replanner: knows the map, and which plan would be made now.
        energy: the mission's energy; None if its plans ignore energy.
    """

    def __init__(
        self,
        flight: Flight,
        assumptions: Assumptions,
        replanner: Replanner,
        energy: MissionEnergy | None = None,
    ) -> None:
        self._energy = None if energy is None else EnergyWatch(flight, energy)
        self._flight = flight
        self._assumptions = assumptions
        self._replanner = replanner
        self._reachability = replanner.reachability
        self._cut_off, self._line = Question[str | None](), Question[str | None]()
        self._possible, self._late = Question[bool](), Question[str | None]()
        self._figure = Question[str | None]()
        self._flown_on_paper: tuple[Lasso, int] | None = None
        self.has_used_slice = False

    def adopt(self, lasso: Lasso) -> None:
        """Begins to watch a plan."""
        self._assumptions.narrow(lasso)
        if self._energy is not None:
            self._energy.adopt(lasso)

    def abandon(self) -> None:
        """Drops all open questions, because their plan is no longer flown."""
        for question in self._questions:
            question.abandon()

    @property
    def is_thinking(self) -> bool:
        """Whether a question about the plan is not answered yet."""
        return any(question.is_open for question in self._questions)

    @property
    def _questions(self) -> tuple[Question[str | None] | Question[bool], ...]:
        return self._cut_off, self._line, self._possible, self._late, self._figure

    def look(self, plan: PlanUnderWay) -> None:
        """Checks events and map; adopts changed events if the plan is still the best one."""
        assumptions, self.has_used_slice = self._assumptions, False
        if self._energy is not None:
            self._energy.meter.step()
        assumptions.narrow(plan.lasso)
        if self._flight.progress.is_landed_by_plan:
            assumptions.note_wrong()
            return
        if not plan.is_leaving and assumptions.wrong and self._is_confirmed(plan):
            assumptions.renew()
        self._reachability.look()

    def _is_confirmed(self, plan: PlanUnderWay) -> bool:
        """Whether the planner would make the same plan now, with the costs of the present map.

        If this takes more than a slice, the answer is no: a new plan is then made, from the next
        tick on.
        """
        self._reachability.search()
        self.has_used_slice = not self._reachability.is_known
        if self.has_used_slice:
            return False

        def confirms() -> bool:
            self._replanner.follow_map()
            return self._replanner.search_confirms(plan.lasso)

        is_confirmed = ask_once(confirms)
        self.has_used_slice = is_confirmed is None
        return bool(is_confirmed)

    def before_the_tree(self, plan: PlanUnderWay) -> str | None:
        """Why another plan is due, before the plan's tree is ticked; None if none is."""
        return self._first_reason(BEFORE_THE_TREE, plan)

    def after_the_tree(self, plan: PlanUnderWay) -> str | None:
        """Why another plan is due, after the plan's tree was ticked; None if none is."""
        return self._first_reason(AFTER_THE_TREE, plan)

    def _first_reason(self, triggers: tuple[ReplanTrigger, ...], plan: PlanUnderWay) -> str | None:
        for trigger in triggers:
            if trigger.guard(self, plan) and (reason := trigger.reason(self, plan)) is not None:
                return reason
        return None

    # -- the map cuts off a belief -------------------------------------------------------------

    def _map_differs(self, _: PlanUnderWay) -> bool:
        is_news = self._reachability.has_changed or self._cut_off.is_open
        return is_news and not self._flight.progress.is_landed_by_plan

    def _cut_off_by_map(self, plan: PlanUnderWay) -> str | None:
        """A belief that the plan needs was given up, once the routes on the map are known."""
        self._late.abandon()  # it takes over the map, too
        self._reachability.search()
        if not self._reachability.is_known:
            return None

        def reason() -> str | None:
            cut_off = self._replanner.follow_map()
            if cut_off is None or plan.is_leaving or self._replanner.search_confirms(plan.lasso):
                return None
            return cut_off.text

        answered = self._cut_off.ask("the map", reason)
        return answered.answer if answered else None

    # -- the charge does not last ------------------------------------------------------------

    def _looks_at_charge(self, plan: PlanUnderWay) -> bool:
        energy, progress = self._energy, self._flight.progress
        may_look = energy is not None and energy.is_due
        return may_look and not plan.is_leaving and not progress.is_landed_by_plan

    def _charge_is_short(self, plan: PlanUnderWay) -> str | None:
        assert self._energy is not None
        return self._energy.shortage()

    def _is_figure_wrong(self, plan: PlanUnderWay) -> bool:
        energy, is_landed = self._energy, self._flight.progress.is_landed_by_plan
        if energy is None or plan.is_leaving or is_landed:
            return False
        return self._figure.is_open or energy.is_figure_wrong

    def _figure_is_wrong(self, plan: PlanUnderWay) -> str | None:
        """If flights take less, the charge lasts for the plan: it is kept if there is no other."""
        energy = self._energy
        assert energy is not None

        def reason() -> str | None:
            does_last, figure = not energy.takes_more, energy.take_factor()
            return None if does_last and self._replanner.plan_now() is None else figure

        answered = self._figure.ask(plan.lasso, reason)
        return answered.answer if answered else None

    # -- the task has a plan again -------------------------------------------------------------

    def _may_be_possible(self, plan: PlanUnderWay) -> bool:
        return plan.is_leaving and (
            self._assumptions.may_do_better or bool(self._assumptions.wrong)
        )

    def _possible_again(self, _: PlanUnderWay) -> str | None:
        """After restored beliefs or changed events; the flight continues during the search."""
        task = self._flight.task
        if not task.violated:
            about = tuple(self._assumptions.wrong), task.withdrawn
            answered = self._possible.ask(about, lambda: self._replanner.is_possible)
            if answered is None:
                return None
            if answered.answer:
                return self._assumptions.surprise or BELIEF_CAME_BACK
        self._assumptions.forget_restored_beliefs()
        self._assumptions.renew()
        return None

    # -- a line that was dropped can be kept ---------------------------------------------------

    def _may_take_up(self, _: PlanUnderWay) -> bool:
        return self._flight.task.may_take_up and not self._flight.progress.is_landed_by_plan

    def _taken_up(self, plan: PlanUnderWay) -> str | None:
        """Asked once after each completed skill; changes of an event do not ask again.

        Those that matter to the plan lead to another one, which considers all lines.
        """
        task = self._flight.task
        if plan.is_leaving:
            task.keep_dropped()
            return None
        answered = self._line.ask(task.completed, lambda: self._replanner.line_to_take_up)
        if answered is None:
            return None
        task.keep_dropped()
        return None if answered.answer is None else f"{answered.answer} has a plan again"

    # -- a bound will be late ------------------------------------------------------------------

    def _may_be_late(self, plan: PlanUnderWay) -> bool:
        if not self._replanner.is_timed or plan.is_leaving or self._map_differs(plan):
            return False
        progress, is_flying = self._flight.progress, self._flight.task.running is not None
        is_news = self._flown_on_paper != (plan.lasso, progress.completed)
        return is_flying and is_news and not progress.is_landed_by_plan

    def _will_be_late(self, plan: PlanUnderWay) -> str | None:
        """Asked once after each completed skill."""
        about = plan.lasso, self._flight.progress.completed
        answered = self._late.ask(about, lambda: self._replanner.lateness(plan.lasso))
        if answered is None:
            return None
        self._flown_on_paper = about
        return answered.answer

    # -- the tree has failed -------------------------------------------------------------------

    def _has_failed(self, plan: PlanUnderWay) -> bool:
        return plan.tree.has_failed

    def _failure(self, plan: PlanUnderWay) -> str | None:
        """An assumption is wrong, a skill has failed, or a belief has come back."""
        if plan.is_leaving:
            return plan.tree.failure
        unexpected = self._assumptions.surprise or plan.tree.failure
        return unexpected or self._violation or BELIEF_CAME_BACK

    # -- a line that the plan keeps is violated ------------------------------------------------

    def _is_in_vain(self, plan: PlanUnderWay) -> bool:
        """A plan that has landed the vehicle ends first."""
        if plan.is_leaving or self._violation is None:
            return False
        progress = self._flight.progress
        is_over = plan.lasso.ends_at_rest and progress.laps > 0
        return is_over or not progress.is_landed_by_plan

    def _in_vain(self, _: PlanUnderWay) -> str | None:
        return self._assumptions.surprise or self._violation

    # -- the plan ends on the ground, where nobody looked ------------------------------------------

    def _ends_surprised(self, plan: PlanUnderWay) -> bool:
        is_over = plan.lasso.ends_at_rest and self._flight.progress.laps > 0
        return is_over and not plan.is_leaving and bool(self._assumptions.wrong)

    def _surprise(self, _: PlanUnderWay) -> str | None:
        return self._assumptions.surprise

    @property
    def _violation(self) -> str | None:
        """What is violated, in words; None if nothing is."""
        task = self._flight.task
        violated = *task.violated, *task.violated_anew
        return f"{', '.join(violated)} violated" if violated else None


_T = ReplanTriggers
BEFORE_THE_TREE = (
    ReplanTrigger("the map cuts off a belief of the plan", _T._map_differs, _T._cut_off_by_map),
    ReplanTrigger("the charge does not last", _T._looks_at_charge, _T._charge_is_short),
    ReplanTrigger("flights take another energy", _T._is_figure_wrong, _T._figure_is_wrong),
    ReplanTrigger("the task has a plan again", _T._may_be_possible, _T._possible_again),
    ReplanTrigger("a line that was dropped can be kept", _T._may_take_up, _T._taken_up),
    ReplanTrigger("a bound will be late", _T._may_be_late, _T._will_be_late),
)
AFTER_THE_TREE = (
    ReplanTrigger("the tree has failed", _T._has_failed, _T._failure),
    ReplanTrigger("a line of the task is violated", _T._is_in_vain, _T._in_vain),
    ReplanTrigger("the end is not as predicted", _T._ends_surprised, _T._surprise),
)
REPLAN_TRIGGERS = (*BEFORE_THE_TREE, *AFTER_THE_TREE)
"""In the order in which each tick checks them; the first one with a reason decides."""
