"""The states of the executive: a class for each, with what belongs to it alone.

    Idle          -> Executing | ByHand                       the first plan, or the mission's tree
    Executing     -> Searching | Satisfied                    another plan is due, or it is done
    Searching     -> Executing | AwaitingPlan | WithoutPlan   deliberation.py decides
    AwaitingPlan  -> Executing | Searching | WithoutPlan      the same
    WithoutPlan   -> Leaving                                  to a safe place
    Leaving       -> Searching | Satisfied                    another plan is due, or it is there
    ByHand        -> Satisfied | WithoutPlan                  the tree has succeeded or failed
    Grounded      -> Executing | Leaving | ByHand             the vehicle has taken off

A search that ends in the same tick is no state. After a pause, every plan leads to Searching. What
begins while the vehicle is on the ground is Grounded first. A vehicle that has lost its way to one
safe place and waits for a plan may leave for another one.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import ClassVar

from companion.acting.behaviour_tree.ticked_tree import TickedTree
from companion.acting.plan_under_way import (
    LeftPlan,
    PlanUnderWay,
    SafePlaceFlight,
    TaskPlan,
)
from companion.acting.replanning.replanner import DueReplan, PlanFailure


class TaskStatus(Enum):
    """The status of the task."""

    RUNNING = "running"
    NEEDS_TAKE_OFF = "goes on in the air"
    SATISFIED = "satisfied"
    NO_PLAN = "no plan"


@dataclass(frozen=True, slots=True)
class Idle:
    """No plan was made yet, or none since the companion was away."""

    status: ClassVar = TaskStatus.RUNNING
    plan: ClassVar[None] = None
    failure: ClassVar[None] = None


@dataclass(frozen=True, slots=True)
class Executing:
    """Ticks the tree of a plan for the task."""

    status: ClassVar = TaskStatus.RUNNING
    failure: ClassVar[None] = None
    plan: TaskPlan

    @property
    def tree(self) -> TickedTree:
        """The tree that is ticked."""
        return self.plan.tree


@dataclass(frozen=True, slots=True)
class Leaving:
    """Ticks the tree of a flight to a safe place.

    Attributes:
        plan: the flight.
        failure: why the task has no plan; None if nobody has searched for one.
    """

    status: ClassVar = TaskStatus.RUNNING
    plan: SafePlaceFlight
    failure: PlanFailure | None

    @property
    def tree(self) -> TickedTree:
        """The tree that is ticked."""
        return self.plan.tree


@dataclass(frozen=True, slots=True)
class ByHand:
    """Ticks the mission's own tree."""

    status: ClassVar = TaskStatus.RUNNING
    plan: ClassVar[None] = None
    failure: ClassVar[None] = None
    tree: TickedTree


@dataclass(frozen=True, slots=True)
class Grounded:
    """Waits until the vehicle has taken off; it is on the ground by what has failed.

    Attributes:
        then: the state in the air.
    """

    status: ClassVar = TaskStatus.NEEDS_TAKE_OFF
    then: Executing | Leaving | ByHand

    @property
    def plan(self) -> PlanUnderWay | None:
        """The plan that is flown in the air."""
        return self.then.plan

    @property
    def failure(self) -> PlanFailure | None:
        """Why the task has no plan."""
        return self.then.failure

    @property
    def tree(self) -> TickedTree:
        """The tree that is ticked in the air."""
        return self.then.tree


@dataclass(frozen=True, slots=True)
class Searching:
    """Searches a plan, or the reason why there is none; the vehicle holds.

    Attributes:
        due: why.
        plan: the plan that was left; None if another process has flown it.
        failure: why earlier searches since then found no plan; None if there were none.
        is_explaining: whether there is no plan, and the reason is being searched for.
    """

    status: ClassVar = TaskStatus.RUNNING
    due: DueReplan
    plan: LeftPlan | None
    failure: PlanFailure | None
    is_explaining: bool = False


@dataclass(frozen=True, slots=True)
class AwaitingPlan:
    """Has no plan, and waits for a change; the vehicle holds.

    Attributes:
        due: why it has searched.
        plan: the plan that was left; None if another process has flown it.
        failure: why there is no plan.
        hopes: the changes that may make a plan possible, in words.
        left_s: how long it waited at most, when it found no plan.
    """

    status: ClassVar = TaskStatus.RUNNING
    due: DueReplan
    plan: LeftPlan | None
    failure: PlanFailure
    hopes: tuple[str, ...]
    left_s: float


@dataclass(frozen=True, slots=True)
class WithoutPlan:
    """The task has no plan.

    Attributes:
        plan: the plan that was left; None after a tree written by hand.
        failure: why there is none, or why the tree has failed.
        reason: why the plan was left, or why the tree has failed.
    """

    status: ClassVar = TaskStatus.NO_PLAN
    plan: LeftPlan | None
    failure: PlanFailure
    reason: str


@dataclass(frozen=True, slots=True)
class Satisfied:
    """The plan, the flight to a safe place, or the tree written by hand is done.

    Attributes:
        plan: the plan that was flown; None for a tree written by hand.
        failure: why the task is not satisfied for all that; None if it is.
    """

    status: ClassVar = TaskStatus.SATISFIED
    plan: PlanUnderWay | None
    failure: PlanFailure | None


InTheAir = Executing | Leaving | ByHand
"""The states that tick a tree."""
WithTree = InTheAir | Grounded
ExecutiveState = Idle | WithTree | Searching | AwaitingPlan | WithoutPlan | Satisfied
