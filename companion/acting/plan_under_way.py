"""The plan that is flown, and what is remembered of one that was left; a class for each purpose."""

from __future__ import annotations

from dataclasses import dataclass

from companion.acting.behaviour_tree.ticked_tree import TickedTree
from companion.planning.lasso import Lasso


@dataclass(frozen=True, slots=True)
class TaskPlan:
    """A plan for the task, with the behaviour tree that flies it."""

    lasso: Lasso
    tree: TickedTree

    @property
    def left(self) -> LeftTaskPlan:
        """What is remembered of it when it is left."""
        return LeftTaskPlan(self.lasso)


@dataclass(frozen=True, slots=True)
class SafePlaceFlight:
    """A flight to a safe place, because there is no plan for the task."""

    lasso: Lasso
    tree: TickedTree

    @property
    def left(self) -> LeftSafePlaceFlight:
        """What is remembered of it when it is left."""
        return LeftSafePlaceFlight(self.lasso, self.tree.failure if self.tree.has_failed else None)


@dataclass(frozen=True, slots=True)
class LeftTaskPlan:
    """A plan for the task that is no longer flown."""

    lasso: Lasso


@dataclass(frozen=True, slots=True)
class LeftSafePlaceFlight:
    """A flight to a safe place that has ended elsewhere.

    Attributes:
        lasso: its plan.
        way_lost: why it has failed; None if it has not.
    """

    lasso: Lasso
    way_lost: str | None = None


PlanUnderWay = TaskPlan | SafePlaceFlight
LeftPlan = LeftTaskPlan | LeftSafePlaceFlight
