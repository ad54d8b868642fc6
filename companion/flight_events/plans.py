"""Events about plans: one was made, made anew, not found, or a lap of one is done."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Annotated, Literal

from companion.flight_events.event import FlightEvent
from companion.flight_events.event_fields import Doc, Reason

PLAN_NUMBER = Doc("of the plan; 0 is the first, N the one after replan N")
Task = Annotated[
    Mapping[str, str],
    Doc("each line of the task by its name: the formula, without patterns and goals"),
]
Priorities = Annotated[
    Mapping[str, int],
    Doc("the priority of each line of the task that may be dropped, by its name"),
]
Dropped = Annotated[
    tuple[str, ...], Doc("a list of the lines of the task that the plan does not keep")
]
Explanation = Annotated[str, Doc("why there is no plan, in words")]
Cost = Annotated[float, Doc("expected duration in seconds")]


@dataclass(frozen=True, slots=True)
class PlannedAction:
    """An action of a plan."""

    action: Annotated[str, Doc("as the mission spells it, e.g. `move(A, B)`")]
    skill: Annotated[str, Doc("the skill's name")]
    arguments: Annotated[tuple[str, ...], Doc("what the skill's parameters are bound to")]
    cost_s: Cost


Actions = Annotated[tuple[PlannedAction, ...], Doc("lists of `{action, skill, arguments, cost_s}`")]


@dataclass(frozen=True, slots=True)
class PlannedLasso:
    """A plan as it is told and kept: `prefix` once, then `loop` for ever.

    >>> move = PlannedAction("move(A, B)", "move", ("A", "B"), 5.0)
    >>> print(PlannedLasso((move,), (PlannedAction("wait", "wait", (), 0.1),), 5.0, 0.1))
    move(A, B), (wait)^w
    """

    prefix: Actions
    loop: Actions
    prefix_cost_s: Cost
    lap_cost_s: Cost

    def __str__(self) -> str:
        prefix = "".join(f"{step.action}, " for step in self.prefix)
        return f"{prefix}({', '.join(step.action for step in self.loop)})^w"


Plan = Annotated[
    PlannedLasso,
    Doc(
        "`prefix` and `loop`, lists of `{action, skill, arguments, cost_s}`; `prefix_cost_s` and "
        "`lap_cost_s`, the expected durations"
    ),
]


@dataclass(frozen=True, slots=True)
class PlanMade(FlightEvent):
    """The first plan was made."""

    kind = "plan"
    template = "plan: {plan}"

    number: Annotated[Literal[0], PLAN_NUMBER] = field(default=0, kw_only=True)
    task: Task
    plan: Plan
    priorities: Priorities = field(default_factory=dict)
    dropped: Dropped = ()


@dataclass(frozen=True, slots=True)
class WrittenTreeAdopted(FlightEvent):
    """The mission brings its own tree, and nothing is planned."""

    kind = "plan"
    template = "flying the mission's own tree"

    number: Annotated[Literal[0], PLAN_NUMBER] = field(default=0, kw_only=True)
    task: Task
    priorities: Priorities = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class TaskRecalled(FlightEvent):
    """A resumed flight writes its task again, as the record has lost its first plan."""

    kind = "task"
    template = "the task as it is flown; the beginning of this record was lost"
    is_told = False

    task: Task
    priorities: Priorities = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class PlanReplaced(FlightEvent):
    """Another plan was made."""

    kind = "replan"
    template = "replan {number}: {reason} -> {plan}"

    number: Annotated[int, PLAN_NUMBER]
    reason: Reason
    plan: Plan
    dropped: Dropped = ()


@dataclass(frozen=True, slots=True)
class LineDropped(FlightEvent):
    """Plans no longer keep a line of the task, until it can be kept again."""

    kind = "dropped"
    template = "{line} dropped: {reason}"

    line: Annotated[str, Doc("the name of the line of the task")]
    reason: Reason


@dataclass(frozen=True, slots=True)
class LineTakenUp(FlightEvent):
    """Plans keep a line of the task again that was dropped or violated."""

    kind = "taken up"
    template = "{line} {what}"

    line: Annotated[str, Doc("the name of the line of the task")]
    anew: Annotated[bool, Doc("whether it begins anew because it was violated")]

    @property
    def what(self) -> str:
        """In words."""
        return "begins anew" if self.anew else "taken up again"


@dataclass(frozen=True, slots=True)
class EngineFailed(FlightEvent):
    """The external engine made no plan, so the built-in search plans."""

    kind = "engine failed"
    template = "{reason}; the built-in search plans instead"

    reason: Reason


@dataclass(frozen=True, slots=True)
class NoPlanFound(FlightEvent):
    """There is no other plan."""

    kind = "replan"
    template = "replan {number}: {reason}: {explanation}"

    number: Annotated[int, PLAN_NUMBER]
    reason: Reason
    explanation: Explanation


@dataclass(frozen=True, slots=True)
class PlanAwaited(FlightEvent):
    """There is no plan now; the vehicle holds, since one may become possible again."""

    kind = "awaited"
    template = "{explanation} Holding for up to {patience_s:g} s for a change of {listed}"

    explanation: Explanation
    patience_s: Annotated[float, Doc("seconds that are left")]
    hopes: Annotated[tuple[str, ...], Doc("a list of the changes that may make a plan possible")]

    @property
    def listed(self) -> str:
        """The hopes in words."""
        return ", ".join(self.hopes)


@dataclass(frozen=True, slots=True)
class LapCompleted(FlightEvent):
    """Everything that the task demands again and again was done once more."""

    kind = "lap"
    template = "lap {lap} done"

    lap: Annotated[int, Doc("how many laps are done, over all plans of the flight")]
