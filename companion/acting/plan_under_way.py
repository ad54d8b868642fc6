"""The plan that is flown, and what is remembered of one that was left."""

from __future__ import annotations

from dataclasses import dataclass

from companion.acting.behaviour_tree.ticked_tree import TickedTree
from companion.planning.lasso import Lasso


@dataclass(frozen=True, slots=True)
class PlanUnderWay:
    """A plan that is flown.

    Attributes:
        lasso: the plan.
        tree: its behaviour tree.
        is_leaving: whether it flies to a safe place, because there is no plan for the task.
    """

    lasso: Lasso
    tree: TickedTree
    is_leaving: bool


@dataclass(frozen=True, slots=True)
class LeftPlan:
    """A plan that is no longer flown; its tree is stopped.

    Attributes:
        lasso: the plan.
        is_leaving: whether it was the flight to a safe place.
        way_lost: why that flight has failed; None if it has not, or was for the task.
    """

    lasso: Lasso
    is_leaving: bool = False
    way_lost: str | None = None
