"""The states of the executive, and the status of the task in each."""

from __future__ import annotations

from enum import Enum


class ExecutiveState(Enum):
    """What the executive is doing."""

    IDLE = "no plan was made yet"
    EXECUTING = "ticks the tree of a plan"
    LEAVING = "ticks the tree of a flight to a place, because the task has no plan"
    BY_HAND = "ticks the mission's own tree"
    GROUNDED = "goes on in the air, while the vehicle is on the ground by what has failed"
    REPLANNING = "a plan is due: routes are searched, or an engine plans; the vehicle holds"
    EXPLAINING = "searches for the reason why there is no plan; the vehicle holds"
    AWAITING_PLAN = "has no plan, and waits for a change; the vehicle holds"
    SATISFIED = "the task is satisfied"
    WITHOUT_PLAN = "the task has no plan"


FLIES_BY_PLAN = frozenset(
    {ExecutiveState.EXECUTING, ExecutiveState.REPLANNING, ExecutiveState.EXPLAINING}
)
"""The states in which there is a plan that leads to more positions, or may be one at once."""


class TaskStatus(Enum):
    """The status of the task."""

    RUNNING = "running"
    NEEDS_TAKE_OFF = "goes on in the air"
    SATISFIED = "satisfied"
    NO_PLAN = "no plan"


STATUS = {
    ExecutiveState.GROUNDED: TaskStatus.NEEDS_TAKE_OFF,
    ExecutiveState.SATISFIED: TaskStatus.SATISFIED,
    ExecutiveState.WITHOUT_PLAN: TaskStatus.NO_PLAN,
}
"""The status of the task in each state; it is running in all others."""
