"""What one conjunct has read of the word, and since when it waits for what it has to meet again.

A conjunct reads every letter, also while its line of the task is dropped, so that it knows its past
when it is taken up again.
"""

from __future__ import annotations

from copy import copy

from companion.ltl.monitor import Runs
from companion.planning.lasso import Conjunct, Letter

MAX_TRIES = 2
"""Interrupted in a row, after which what was tried waits its turn again."""


class Reading:
    """What one conjunct has read: the letters, and where its automaton may be after them.

    Attributes:
        since_s: for each acceptance mark, since when it waits.
        left_to_meet: the marks that were not met yet in this lap of the task.
    """

    def __init__(self, conjunct: Conjunct) -> None:
        self._begin = Runs.begin(conjunct.automaton)
        self.conjunct = conjunct
        self.restart(0.0)
        self.begin_lap()

    def restart(self, now_s: float) -> None:
        """Begins anew."""
        self.letters: list[Letter] = []
        self.runs = self._begin
        self.since_s = [now_s] * self.conjunct.automaton.marks
        self._tries = [0] * self.conjunct.automaton.marks

    def anew(self, now_s: float) -> Reading:
        """Another one of the same conjunct, which begins now."""
        fresh = copy(self)  # nothing of it is changed in place
        fresh.restart(now_s)
        return fresh

    def begin_lap(self) -> None:
        """Every mark is to be met again."""
        self.left_to_meet = frozenset(range(self.conjunct.automaton.marks))

    def since_with(self, letter: Letter, reached_s: float) -> list[float]:
        """Since when each mark waits, with one more position."""
        met = self.runs.marks_met(letter)
        return [reached_s if mark in met else since for mark, since in enumerate(self.since_s)]

    def try_in_vain(self, letter: Letter, begun_s: float) -> None:
        """A position with this letter was not reached."""
        for mark in self.runs.marks_met(letter):
            self._tries[mark] += 1
            if self._tries[mark] >= MAX_TRIES:
                self.since_s[mark] = begun_s

    def read(self, letter: Letter, reached_s: float) -> bool:
        """One more position; whether it violates the conjunct, which it did not before."""
        could_hold = bool(self.runs.states) or not self.letters  # what is never true is told too
        self.since_s = self.since_with(letter, reached_s)
        for mark in self.runs.marks_met(letter):
            self._tries[mark] = 0
            self.left_to_meet -= {mark}
        self.runs = self.runs.after(letter)
        self.letters.append(letter)
        return could_hold and not self.runs.states
