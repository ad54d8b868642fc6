"""The steps of a skill that must not be done twice: commands to payloads, and calls of functions.

1. The journal has a step on the disk before the step begins. The step stays open there until its
   skill is completed, or the step or its try fails.
2. An interruption (a pause, a pilot, a lost link, another plan) ends the waiting for a command, but
   not the command. If the skill begins again at the same position of the word, it learns the
   outcomes of its steps: a step that is done is not done again.
3. When a try has failed, the next one does all of its steps again.
4. At another position of the word, the same skill has new steps.
"""

from __future__ import annotations

from collections.abc import Callable, Collection
from dataclasses import dataclass, field

from companion.acting.journal import CommandIntended, CommandSettled, JournalEntry
from companion.mission.steps import Command
from companion.planning.domain import Action


@dataclass(frozen=True, slots=True)
class StepOwner:
    """Identifies a step.

    Attributes:
        action: the skill, with `*` for the place from which it flies: after an interruption on its
            way it continues from `here`, and counts as the same skill.
        position: the position of the word at which the skill is done.
        nth: which leaf of the skill's tree, from 0.
        asked: which of the commands that a function requests, from 1; 0 for the leaf's own step.
        begun_as: name of the present action; it is not part of the identity.
    """

    action: str
    position: int
    nth: int
    asked: int = 0
    begun_as: str = field(default="", compare=False)


@dataclass
class BegunStep:
    """A step that has begun, or is about to.

    Attributes:
        does: the command, or the text of a call.
        number: number of its intention in the journal.
        intended_s: when the intention was noted in the journal.
        ticket: ticket of the command; None before it is sent and after its final answer.
        is_done: whether it was done.
        is_resumed: whether its skill has returned to it after an interruption.
    """

    does: Command | str
    number: int
    intended_s: float
    ticket: int | None = None
    is_done: bool = False
    is_resumed: bool = False


class BegunSteps:
    """The begun steps at the present position of the word.

    Args:
        forget: drops the command of a ticket.
        note: adds an entry to the journal.
    """

    def __init__(self, forget: Callable[[int], None], note: Callable[[JournalEntry], None]) -> None:
        self._forget_ticket = forget
        self._note = note
        self._steps: dict[StepOwner, BegunStep] = {}
        self._intentions = 0

    def begin(self, owner: StepOwner, does: Command | str, now_s: float) -> BegunStep:
        """Returns the step that its owner began before an interruption, or a new one.

        Args:
            owner: which step it is.
            does: what it does. If that differs from before, the step is a new one.
            now_s: the time.
        """
        for other, step in [*self._steps.items()]:
            if other.position != owner.position or (other == owner and step.does != does):
                self._forget(other)
        if (before := self._steps.get(owner)) is not None:
            before.is_resumed = True
            return before
        self._intentions += 1
        self._steps[owner] = step = BegunStep(does, self._intentions, now_s)
        text = does if isinstance(does, str) else does.name
        self._note(CommandIntended(self._intentions, owner.begun_as, text))
        return step

    def since_s(self, action: str, now_s: float) -> float:
        """The time from which a reading can confirm an action whose steps are done.

        It is the present time, unless the last step was done before an interruption. Then the
        effect of that step may have been heard meanwhile, and may never be heard again.
        """
        own = [step for o, step in self._steps.items() if o.action == action and not o.asked]
        last = max(own, key=lambda step: step.number, default=None)
        return last.intended_s if last is not None and last.is_resumed else now_s

    def drop(self, owner: StepOwner) -> None:
        """Ends a step that has failed or has not really begun."""
        step = self._forget(owner)
        self._note(CommandSettled(step.number))

    def end_try(self, leaves: Collection[int]) -> None:
        """Ends the steps of a try that has failed.

        Args:
            leaves: numbers of the leaves that took part in it.
        """
        for owner in [owner for owner in self._steps if owner.nth in leaves]:
            self.drop(owner)

    def end_skill(self, action: Action) -> None:
        """Ends the steps of a skill that has failed, after all its tries."""
        for owner in [owner for owner in self._steps if owner.action == action.from_anywhere]:
            self.drop(owner)

    def _forget(self, owner: StepOwner) -> BegunStep:
        step = self._steps.pop(owner)
        if step.ticket is not None:
            self._forget_ticket(step.ticket)
        return step
