"""The changes of a task's state, as data: a class for each kind of change.

`TaskState` reports each change that is made to it. task_replay.py makes the same changes to a fresh
state of the same mission, and that becomes the same state. So no state has to be written down, and
no part of it can be forgotten.

Actions, events and facts appear by their names.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class TaskMoment:
    """When a change was made.

    Attributes:
        positions: how many positions of the word had been left after the change.
        now_s: the time; 0 if the task has no clocks.
    """

    positions: int
    now_s: float


@dataclass(frozen=True, slots=True)
class TimedChange:
    """What all changes have."""

    at: TaskMoment


@dataclass(frozen=True, slots=True)
class ActionBegun(TimedChange):
    """The present position was left for the one that an action leads to."""

    action: str


@dataclass(frozen=True, slots=True)
class ActionCompleted(TimedChange):
    """The position that an action leads to was reached, at time `reached_s`."""

    action: str
    reached_s: float


@dataclass(frozen=True, slots=True)
class ActionInterrupted(TimedChange):
    """The action under way ended without its effects."""


@dataclass(frozen=True, slots=True)
class FlightResumed(TimedChange):
    """The flight that was interrupted last was resumed."""

    action: str


@dataclass(frozen=True, slots=True)
class ActionBarred(TimedChange):
    """No plan may contain an action any more."""

    action: str


@dataclass(frozen=True, slots=True)
class SkillsPutAside(TimedChange):
    """No plan has these skills until an event or a belief comes."""

    skills: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class SkillsPutBack(TimedChange):
    """Plans may have the skills again that were put aside."""


@dataclass(frozen=True, slots=True)
class SkillOverdue(TimedChange):
    """A skill works longer than its cost: at least this time."""

    skill: str
    least_ms: int


@dataclass(frozen=True, slots=True)
class OverdueForgotten(TimedChange):
    """No skill counts as overdue any more."""


@dataclass(frozen=True, slots=True)
class PositionRead(TimedChange):
    """The automata read the present position."""


@dataclass(frozen=True, slots=True)
class VehicleDeparted(TimedChange):
    """The vehicle left its place, and is at no place."""


@dataclass(frozen=True, slots=True)
class EventValueTaken(TimedChange):
    """An event got a new value."""

    event: str
    holds: bool


@dataclass(frozen=True, slots=True)
class BeliefsWithdrawn(TimedChange):
    """Beliefs were disproved; from time `retry_s` on, if given, they may be held again."""

    beliefs: tuple[str, ...]
    retry_s: float | None


@dataclass(frozen=True, slots=True)
class BeliefsCutOff(TimedChange):
    """The map contradicts these beliefs, and no others."""

    beliefs: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class BeliefsRestored(TimedChange):
    """Withdrawn beliefs were held again, as `TaskState.restore` chooses them."""

    restored_s: float
    is_waiting: bool
    predicates: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class LinesDropped(TimedChange):
    """A plan was adopted that drops these lines and keeps all others."""

    lines: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class DroppedLinesKept(TimedChange):
    """Dropped lines stay dropped until a skill is completed."""


@dataclass(frozen=True, slots=True)
class ClocksChanged(TimedChange):
    """The clocks of bounded lines began, or ran out."""


TaskChange = (
    ActionBegun
    | ActionCompleted
    | ActionInterrupted
    | FlightResumed
    | ActionBarred
    | SkillsPutAside
    | SkillsPutBack
    | SkillOverdue
    | OverdueForgotten
    | PositionRead
    | VehicleDeparted
    | EventValueTaken
    | BeliefsWithdrawn
    | BeliefsCutOff
    | BeliefsRestored
    | LinesDropped
    | DroppedLinesKept
    | ClocksChanged
)
