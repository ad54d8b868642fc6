"""What a hypothetical flight does about a change: goes on, plans anew, lands, or stays.

What decides is what decides in flight: the deliberation about plans, and the choice of a safe
place. What has begun on the ground is finished first.
"""

from __future__ import annotations

from companion.acting.contingencies.answers import (
    Answer,
    GoesOn,
    LandsAt,
    Replans,
    StaysWhereItIs,
)
from companion.acting.contingencies.changes import BeliefLost, Change, DrainUp, SiteLost
from companion.acting.contingencies.hypothetical_flight import HypotheticalFlight
from companion.acting.deliberation import PlanChosen, PlanDecision
from companion.acting.executive_states import AwaitingPlan, Searching, WithoutPlan
from companion.acting.plan_under_way import LeftTaskPlan
from companion.acting.replanning.assumptions import BELIEF_CAME_BACK
from companion.acting.replanning.replanner import PlanFailure, ReplanReason
from companion.acting.safe_places import AtSafePlace, NoSafePlace, SafePlaces, WayToSafePlace
from companion.mission.otherwise import Otherwise
from companion.planning.charger import UNITS_PER_WH
from companion.planning.energy_check import of_reserve
from companion.planning.lasso import ChosenPlan, Lasso


class Reaction:
    """The reaction of a flight to one change.

    Args:
        flown: the flight, at the position where the change happens.
    """

    def __init__(self, flown: HypotheticalFlight) -> None:
        self._flown, self._planner = flown, flown.planner
        self._flight, self._deliberation = flown.flight, flown.deliberation

    def to(self, change: Change) -> tuple[Answer, ChosenPlan | None]:
        """What the flight does about a change now; and the new plan, if it makes one."""
        reason: ReplanReason | None = self._flown.take(change)
        if reason is None:
            self._flown.finish_on_the_ground()
            reason = self._why_to_replan(change)
        if reason is None:
            return GoesOn(), None
        return self._replan(reason)

    def _why_to_replan(self, change: Change) -> ReplanReason | None:
        if isinstance(change, SiteLost) and self._flown.running.destination == change.place:
            return self._flown.fail(self._flown.running)
        if isinstance(change, DrainUp):
            self._flown.scale_energy(1 + change.share)
            return str(change)
        deliberation = self._deliberation
        if isinstance(change, BeliefLost):
            is_kept = deliberation.replanner.search_confirms(self._flown.lasso)
            return None if is_kept else str(change)
        plan, triggers = self._flown.under_way, deliberation.triggers
        triggers.look(plan)
        reason = triggers.before_the_tree(plan)
        while reason is None and triggers.is_thinking:
            reason = triggers.before_the_tree(plan)
        return reason or deliberation.assumptions.surprise

    def _replan(self, reason: ReplanReason) -> tuple[Answer, ChosenPlan | None]:
        """Does what the deliberation decides; a wait ends when a belief is held again."""
        self._flight.task.interrupt()
        decision = self._decided(self._deliberation.replan(reason, LeftTaskPlan(self._flown.lasso)))
        waits_for = decision.hopes if isinstance(decision, AwaitingPlan) else ()
        waited_s, retry_s = 0.0, self._flown.retry_s
        if isinstance(decision, AwaitingPlan) and retry_s is not None:
            if retry_s < decision.left_s:
                waited_s, decision = retry_s, self._after_retry(decision, retry_s)
        if not isinstance(decision, PlanChosen):
            return self._without_plan(decision.failure, waits_for), None
        if decision.is_rest:
            return GoesOn(), None
        plan = decision.plan
        answer = Replans(
            plan.lasso.planned,
            dropped=plan.lines_dropped,
            waited_s=waited_s,
            reserve_wh=self._of_reserve_wh(plan.lasso),
        )
        return answer, plan

    def _decided(self, decision: PlanDecision) -> PlanChosen | AwaitingPlan | WithoutPlan:
        """The decision at the end of a search."""
        while isinstance(decision, Searching):
            decision = self._deliberation.search(decision)
        return decision

    def _after_retry(
        self, waiting: AwaitingPlan, wait_s: float
    ) -> PlanChosen | AwaitingPlan | WithoutPlan:
        """The decision when a withdrawn belief is held again."""
        flight, energy = self._flight, self._planner.energy
        self._flown.pass_time(wait_s)
        if energy is not None and self._flown.charge is not None:
            self._flown.charge.level -= energy.model.hovering(wait_s)
        flight.task.restore(flight.now_s, True, frozenset())
        return self._decided(self._deliberation.search_again(waiting, BELIEF_CAME_BACK))

    def _without_plan(self, failure: PlanFailure, waits_for: tuple[str, ...]) -> Answer:
        """Does what the mission says for the case that no plan exists."""
        why = str(failure).splitlines()[0]
        safe = SafePlaces(self._flight, self._planner, self._flown.mission.safe_places)
        while (decision := safe.decide()) is None:
            pass
        match decision:
            case AtSafePlace(place):
                return LandsAt(place, why, waits_for)
            case WayToSafePlace(place):
                return LandsAt(place, why, waits_for, *self._missing_wh(safe.missing(place)))
            case NoSafePlace():
                is_hold = self._flown.mission.otherwise is Otherwise.HOLD
                does = "holds where it is" if is_hold else "lands where it is"
                return StaysWhereItIs(does, why, not self._flown.mission.safe_places, waits_for)

    def _of_reserve_wh(self, lasso: Lasso) -> float:
        """How much of the reserve a plan from here takes."""
        energy, facts = self._planner.energy, self._flight.task.facts
        if energy is None or not energy.charge.is_flown:
            return 0.0
        return of_reserve(energy.now(is_en_route=True), facts, lasso) / UNITS_PER_WH

    def _missing_wh(self, units: int) -> tuple[float, float]:
        """The missing energy, with the reserve left and with the reserve used."""
        energy = self._planner.energy
        reserve = 0 if energy is None else energy.model.reserve
        return units / UNITS_PER_WH, max(0, units - reserve) / UNITS_PER_WH
