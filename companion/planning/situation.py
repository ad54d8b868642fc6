"""A position of the word as it was left, and the part of a task's state that decides on plans."""

from __future__ import annotations

from dataclasses import dataclass, replace

from companion.mission.facts import Fact
from companion.mission.model import Mission
from companion.planning.lasso import Conjunct


@dataclass(frozen=True, slots=True)
class Position:
    """A position of the word, as it was when it was left.

    Attributes:
        number: its index in the word; the first one is 0.
        facts: what was read; of the beliefs, only those that the task mentions.
        risen: events among `facts` that had risen before and no longer held when they were read.
        reached_s: when the position was appended.
        withdrawn: beliefs that were not held.
        restarted: names of conjuncts that start again at this position.
        violated: conjuncts that no continuation can satisfy from this position on.
        dropped: names of the lines that the plan did not keep, in the order of the file.
    """

    number: int
    facts: frozenset[Fact]
    risen: frozenset[Fact]
    reached_s: float
    withdrawn: frozenset[Fact]
    restarted: tuple[str, ...]
    violated: tuple[Conjunct, ...]
    dropped: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class TaskSituation:
    """The part of a task's state that decides on plans; the fields are those of `TaskState` and its
    word."""

    facts: frozenset[Fact]
    risen: frozenset[Fact]
    withdrawn: frozenset[Fact]
    positions: int
    completed: int

    def changed_events(self, later: TaskSituation) -> frozenset[Fact]:
        """The events that hold, or have risen, in only one of the two situations."""
        return (self.facts ^ later.facts) | (self.risen ^ later.risen)

    def is_like(self, other: TaskSituation, but_for: frozenset[Fact]) -> bool:
        """Whether two situations are equal, except for some events."""
        alike = replace(other, facts=self.facts, risen=self.risen)
        return self == alike and self.changed_events(other) <= but_for


def unread_events(mission: Mission) -> frozenset[Fact]:
    """The events on which no plan depends.

    Neither the task nor a skill mentions them, and they restart no line.
    """
    read = {fact.predicate for fact in mission.task_facts}
    for skill in mission.skills.values():
        conditions = (skill.precondition, *(when.condition for when in skill.conditional))
        read |= {literal.atom.predicate for literals in conditions for literal in literals}
    events = mission.events.items()
    return frozenset(e.fact for name, e in events if name not in read and not e.restarts)
