"""Reports the plans of a flight: the first one, each that replaces another one, and each wait."""

from __future__ import annotations

from companion.acting.executive_states import AwaitingPlan
from companion.acting.flight import Flight
from companion.flight_events.plans import PlanAwaited, PlanMade, PlanReplaced
from companion.mission.model import Mission
from companion.planning.lasso import ChosenPlan


def tell_made(flight: Flight, mission: Mission, plan: ChosenPlan) -> None:
    """Reports the first plan, with the task."""
    made = PlanMade(
        task=mission.written_task,
        plan=plan.lasso.planned,
        priorities=mission.priorities,
        dropped=plan.lines_dropped,
    )
    flight.report(made)


def tell_replaced(flight: Flight, number: int, reason: str, plan: ChosenPlan) -> None:
    """Reports a replacement plan.

    Args:
        number: number of replans so far.
        reason: why it was replaced.
    """
    replaced = PlanReplaced(
        number=number, reason=reason, plan=plan.lasso.planned, dropped=plan.lines_dropped
    )
    flight.report(replaced)


def tell_awaited(flight: Flight, waiting: AwaitingPlan) -> None:
    """Reports that the vehicle begins to wait for a plan, and why."""
    why = str(waiting.failure).splitlines()[0]
    flight.report(PlanAwaited(why, round(waiting.left_s, 1), waiting.hopes))
