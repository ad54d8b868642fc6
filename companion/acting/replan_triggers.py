"""Checks in each tick whether the plan under way has to be replaced.

The triggers are asked in a fixed order; the first one with a reason decides. A flight to a safe
place is replaced for fewer reasons than a plan for the task: it assumes nothing, and ends anyway.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from companion.acting.charge.energy_watch import EnergyWatch
from companion.acting.flight import Flight
from companion.acting.plan_under_way import PlanUnderWay, SafePlaceFlight, TaskPlan
from companion.acting.replanning.assumptions import Assumptions
from companion.acting.replanning.late_plans import LatePlans
from companion.acting.replanning.replanner import BetterPlan, Replanner, ReplanReason
from companion.acting.triggers.after_the_tree import (
    EndSurprised,
    LineViolated,
    TreeFailed,
    WayLost,
)
from companion.acting.triggers.before_the_tree import (
    BoundLate,
    ChargeShort,
    CutOffByMap,
    DroppedLineKept,
    EnergyFigureWrong,
    TaskPossibleAgain,
)
from companion.acting.triggers.trigger import ReplanTrigger, SlicedTrigger
from companion.planning.lasso import Lasso
from companion.planning.planner import Planner
from companion.slices import Question, ask_once


@dataclass(frozen=True, slots=True)
class TriggerOrder:
    """The triggers of plans for one purpose, in their order.

    Attributes:
        before: those before the plan's tree is ticked.
        after: those after it was ticked.
    """

    before: tuple[ReplanTrigger, ...]
    after: tuple[ReplanTrigger, ...]


class ReplanTriggers:
    """Notices what a plan did not expect.

    Attributes:
        of_task: the triggers of plans for the task.
        of_safe_place: those of flights to a safe place.
        has_used_slice: whether this tick's slice of search went into the question whether the plan
            is still the best one, without an answer.

    Args:
        planner: the mission's planner.
        flight: knows the present facts and the progress of the plan.
        assumptions: the assumptions of the plan.
        replanner: knows the map, and which plan would be made now.
    """

    def __init__(
        self, planner: Planner, flight: Flight, assumptions: Assumptions, replanner: Replanner
    ) -> None:
        self._flight, self._assumptions, self._replanner = flight, assumptions, replanner
        self._energy = EnergyWatch(flight, planner.energy) if planner.energy else None
        self.has_used_slice = False
        late = Question[BetterPlan | None]()
        cut_off = CutOffByMap(flight, replanner, outdated=late)
        dropped, possible = (
            DroppedLineKept(flight, replanner),
            TaskPossibleAgain(flight, assumptions, replanner),
        )
        of_charge = _of_charge(flight, self._energy, replanner)
        in_time = BoundLate(flight, LatePlans(planner, flight, replanner), cut_off, late)
        self.of_task = TriggerOrder(
            before=(cut_off, *of_charge, dropped, in_time),
            after=(
                TreeFailed(flight, assumptions),
                LineViolated(flight, assumptions),
                EndSurprised(flight, assumptions),
            ),
        )
        self.of_safe_place = TriggerOrder(before=(cut_off, possible, dropped), after=(WayLost(),))
        asked = dict.fromkeys((*self.of_task.before, *self.of_safe_place.before))
        self._sliced = [each for each in asked if isinstance(each, SlicedTrigger)]

    def adopt(self, lasso: Lasso) -> None:
        """Begins to watch a plan."""
        self._assumptions.narrow(lasso)
        if self._energy is not None:
            self._energy.adopt(lasso)

    def abandon(self) -> None:
        """Drops all open questions, because their plan is no longer flown."""
        for trigger in self._sliced:
            trigger.abandon()

    @property
    def is_thinking(self) -> bool:
        """Whether a question about the plan is not answered yet."""
        return any(trigger.is_thinking for trigger in self._sliced)

    def look(self, plan: PlanUnderWay) -> None:
        """Checks events and map; adopts changed events if the plan is still the best one."""
        assumptions, self.has_used_slice = self._assumptions, False
        if self._energy is not None:
            self._energy.meter.step()
        assumptions.narrow(plan.lasso)
        if self._flight.progress.is_landed_by_plan:
            assumptions.note_wrong()
            return
        if isinstance(plan, TaskPlan) and assumptions.wrong and self._is_confirmed(plan):
            assumptions.renew()
        self._replanner.reachability.look()

    def _is_confirmed(self, plan: TaskPlan) -> bool:
        """Whether the planner would make the same plan now, with the costs of the present map.

        If this takes more than a slice, the answer is no: a new plan is then made, from the next
        tick on.
        """
        reachability = self._replanner.reachability
        reachability.search()
        self.has_used_slice = not reachability.is_known
        if self.has_used_slice:
            return False

        def confirms() -> bool:
            self._replanner.follow_map()
            return self._replanner.search_confirms(plan.lasso)

        is_confirmed = ask_once(confirms)
        self.has_used_slice = is_confirmed is None
        return bool(is_confirmed)

    def _of(self, plan: PlanUnderWay) -> TriggerOrder:
        return self.of_safe_place if isinstance(plan, SafePlaceFlight) else self.of_task

    def before_the_tree(self, plan: PlanUnderWay) -> ReplanReason | None:
        """Why another plan is due, before the plan's tree is ticked; None if none is."""
        return _first_reason(self._of(plan).before, plan)

    def after_the_tree(self, plan: PlanUnderWay) -> ReplanReason | None:
        """Why another plan is due, after the plan's tree was ticked; None if none is."""
        return _first_reason(self._of(plan).after, plan)


def _of_charge(
    flight: Flight, energy: EnergyWatch | None, replanner: Replanner
) -> Sequence[ReplanTrigger]:
    """The triggers of plans that consider energy."""
    if energy is None:
        return ()
    return ChargeShort(flight, energy), EnergyFigureWrong(flight, energy, replanner)


def _first_reason(triggers: Sequence[ReplanTrigger], plan: PlanUnderWay) -> ReplanReason | None:
    for trigger in triggers:
        if trigger.guard(plan) and (reason := trigger.reason(plan)) is not None:
            return reason
    return None
