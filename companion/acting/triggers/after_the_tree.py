"""The reasons to plan again that are looked at after the plan's tree was ticked.

`WayLost` is about flights to a safe place, all others are about plans for the task.
"""

from __future__ import annotations

from companion.acting.flight import Flight
from companion.acting.plan_under_way import PlanUnderWay
from companion.acting.replanning.assumptions import BELIEF_CAME_BACK, Assumptions
from companion.acting.triggers.trigger import ReplanTrigger
from companion.planning.task_state import TaskState


class TreeFailed(ReplanTrigger):
    """The tree has failed: an assumption is wrong, a skill has failed, or a belief has come back.

    Args:
        flight: knows the task.
        assumptions: of the plan.
    """

    def __init__(self, flight: Flight, assumptions: Assumptions) -> None:
        self._task, self._assumptions = flight.task, assumptions

    def guard(self, plan: PlanUnderWay) -> bool:
        """It has failed."""
        return plan.tree.has_failed

    def reason(self, plan: PlanUnderWay) -> str | None:
        """The wrong assumption, or why the tree has failed."""
        unexpected = self._assumptions.surprise or plan.tree.failure
        return unexpected or _violation(self._task) or BELIEF_CAME_BACK


class WayLost(ReplanTrigger):
    """The tree of a flight to a safe place has failed."""

    def guard(self, plan: PlanUnderWay) -> bool:
        """It has failed."""
        return plan.tree.has_failed

    def reason(self, plan: PlanUnderWay) -> str | None:
        """Why the tree has failed."""
        return plan.tree.failure


class LineViolated(ReplanTrigger):
    """A line that the plan keeps is violated; a plan that has landed the vehicle ends first.

    Args:
        flight: knows the task.
        assumptions: of the plan.
    """

    def __init__(self, flight: Flight, assumptions: Assumptions) -> None:
        self._flight, self._assumptions = flight, assumptions

    def guard(self, plan: PlanUnderWay) -> bool:
        """A line is violated."""
        if _violation(self._flight.task) is None:
            return False
        progress = self._flight.progress
        is_over = plan.lasso.ends_at_rest and progress.laps > 0
        return is_over or not progress.is_landed_by_plan

    def reason(self, plan: PlanUnderWay) -> str | None:
        """The event that came, or the line."""
        return self._assumptions.surprise or _violation(self._flight.task)


class EndSurprised(ReplanTrigger):
    """The plan ends on the ground, where nobody looked, and an assumption is wrong.

    Args:
        flight: knows the progress of the plan.
        assumptions: of the plan.
    """

    def __init__(self, flight: Flight, assumptions: Assumptions) -> None:
        self._flight, self._assumptions = flight, assumptions

    def guard(self, plan: PlanUnderWay) -> bool:
        """The plan is over, and an assumption is wrong."""
        is_over = plan.lasso.ends_at_rest and self._flight.progress.laps > 0
        return is_over and bool(self._assumptions.wrong)

    def reason(self, plan: PlanUnderWay) -> str | None:
        """The wrong assumption."""
        return self._assumptions.surprise


def _violation(task: TaskState) -> str | None:
    """What is violated, in words; None if nothing is."""
    violated = *task.violated, *task.violated_kept
    return f"{', '.join(violated)} violated" if violated else None
