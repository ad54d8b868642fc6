"""Reports the plans of a flight, each wait for one, and the laps; counts them."""

from __future__ import annotations

from companion.acting.executive_states import AwaitingPlan, WithoutPlan
from companion.acting.flight import Flight
from companion.flight_events.plans import (
    LapCompleted,
    NoPlanFound,
    PlanAwaited,
    PlanMade,
    PlanReplaced,
)
from companion.mission.model import Mission
from companion.planning.lasso import ChosenPlan


class PlanReports:
    """What is reported of plans.

    Attributes:
        replans: number of replans, also of those that found no plan.
        laps: number of laps of the task, over all plans that do not end.

    Args:
        flight: the flight.
    """

    def __init__(self, flight: Flight) -> None:
        self.replans = self.laps = 0
        self._flight = flight

    def tell_made(self, mission: Mission, plan: ChosenPlan) -> None:
        """The first plan was made, for the task of a mission."""
        made = PlanMade(
            task=mission.written_task,
            plan=plan.lasso.planned,
            priorities=mission.priorities,
            dropped=plan.lines_dropped,
        )
        self._flight.report(made)

    def tell_replaced(self, reason: str, plan: ChosenPlan) -> None:
        """This plan replaces the one before."""
        self.replans += 1
        replaced = PlanReplaced(
            number=self.replans,
            reason=reason,
            plan=plan.lasso.planned,
            dropped=plan.lines_dropped,
        )
        self._flight.report(replaced)

    def tell_awaited(self, waiting: AwaitingPlan) -> None:
        """The vehicle begins to wait for a plan."""
        why = str(waiting.failure).splitlines()[0]
        self._flight.report(PlanAwaited(why, round(waiting.left_s, 1), waiting.hopes))

    def tell_not_found(self, without: WithoutPlan) -> None:
        """There is no plan."""
        self.replans += 1
        self._flight.report(NoPlanFound(self.replans, without.reason, str(without.failure)))

    def tell_laps(self, more: int) -> None:
        """So many laps were completed since the last call."""
        for _ in range(more):
            self.laps += 1
            self._flight.report(LapCompleted(self.laps))
