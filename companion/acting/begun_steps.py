"""The steps of the skill under way that may not be done twice: commands to payloads, and calls.

1. A step is in the journal, on the disk, before it is begun, and stays open there until its skill
   is completed, or it has failed.
2. An interruption (a pause, a pilot, another plan) ends the waiting for a command, and not the
   command. A skill that is begun anew at the same position of the word comes back to the same
   steps, and finds what has become of them; what is done is not done again.
3. A try that has failed is over, and the next one does its steps anew.
4. At another position of the word they are other steps.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass

from companion.acting.journal import CommandIntended, CommandSettled, Journal
from companion.mission.steps import Command
from companion.vehicle.port import Vehicle


@dataclass(frozen=True, slots=True)
class StepOwner:
    """Which step of which skill.

    Attributes:
        action: the skill.
        position: of the word, at which it is done.
        nth: of the leaves of its tree, from 0.
        asked: of the commands that a function has asked for, from 1; 0 is the leaf's own step.
    """

    action: str
    position: int
    nth: int
    asked: int = 0


@dataclass
class BegunStep:
    """A step that is begun, or about to be.

    Attributes:
        does: the command, or the text of a call.
        number: of its intention in the journal.
        intended_s: when that was noted.
        ticket: of the command; None before it is sent, and after its final answer.
        is_done: whether it was done.
    """

    does: Command | str
    number: int
    intended_s: float
    ticket: int | None = None
    is_done: bool = False


class BegunSteps:
    """Those of the position that the word has come to.

    Args:
        vehicle: whose payloads commands are sent to.
    """

    def __init__(self, vehicle: Vehicle) -> None:
        self._vehicle = vehicle
        self._steps: dict[StepOwner, BegunStep] = {}
        self._intentions = 0

    def come_to(
        self, owner: StepOwner, does: Command | str, journal: Journal, now_s: float
    ) -> BegunStep:
        """The step that an owner has begun before, or one that is noted now.

        Args:
            owner: whose step it is.
            does: what it does; where that is something else than before, it is another step.
            journal: keeps the intention.
            now_s: the time.
        """
        for other, step in [*self._steps.items()]:
            if other.position != owner.position or (other == owner and step.does != does):
                self._forget(other)
        if owner not in self._steps:
            self._intentions += 1
            self._steps[owner] = BegunStep(does, self._intentions, now_s)
            text = does if isinstance(does, str) else does.name
            journal.note(now_s, CommandIntended(self._intentions, owner.action, text))
        return self._steps[owner]

    def drop(self, owner: StepOwner, journal: Journal, now_s: float) -> None:
        """A step has failed, or nothing of it was begun."""
        step = self._forget(owner)
        journal.note(now_s, CommandSettled(step.number))

    def end_try(
        self, journal: Journal, now_s: float, leaves: Collection[int] | None = None
    ) -> None:
        """A try has failed.

        Args:
            journal: keeps that.
            now_s: the time.
            leaves: that took part in it; None for all.
        """
        for owner in [o for o in self._steps if leaves is None or o.nth in leaves]:
            self.drop(owner, journal, now_s)

    def end_skill(self, action: str, journal: Journal, now_s: float) -> None:
        """A skill has failed, after all its tries."""
        for owner in [owner for owner in self._steps if owner.action == action]:
            self.drop(owner, journal, now_s)

    def _forget(self, owner: StepOwner) -> BegunStep:
        step = self._steps.pop(owner)
        if step.ticket is not None:
            self._vehicle.payloads.forget(step.ticket)
        return step
