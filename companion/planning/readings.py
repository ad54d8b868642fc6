"""What one conjunct has read of the word, and since when its acceptance marks wait.

A conjunct reads every letter, also while its line of the task is dropped. So it knows its past when
the line is taken up again.
"""

from __future__ import annotations

from copy import copy

from companion.ltl.monitor import Runs
from companion.planning.lasso import Conjunct, Letter

MAX_TRIES = 2
"""After this many interruptions in a row, a mark waits its turn again."""


class Reading:
    """What one conjunct has read: the letters, and the possible automaton states after them.

    Attributes:
        since_s: for each acceptance mark, since when it waits.
        left_to_meet: the marks that have not been met in this lap of the task.
    """

    def __init__(self, conjunct: Conjunct) -> None:
        self._begin = Runs.begin(conjunct.automaton)
        self.conjunct = conjunct
        self.restart(0.0)
        self.begin_lap()

    def restart(self, now_s: float) -> None:
        """Starts the reading again."""
        self.letters: list[Letter] = []
        self.runs = self._begin
        self.since_s = [now_s] * self.conjunct.automaton.marks
        self._tries = [0] * self.conjunct.automaton.marks

    def restarted(self, now_s: float) -> Reading:
        """A new reading of the same conjunct, which starts now."""
        fresh = copy(self)  # none of its attributes is changed in place
        fresh.restart(now_s)
        return fresh

    def begin_lap(self) -> None:
        """Starts a lap: every mark has to be met again."""
        self.left_to_meet = frozenset(range(self.conjunct.automaton.marks))

    def since_with(self, letter: Letter, reached_s: float) -> list[float]:
        """Since when each mark would wait after one more position."""
        met = self.runs.marks_met(letter)
        return [reached_s if mark in met else since for mark, since in enumerate(self.since_s)]

    def try_in_vain(self, letter: Letter, begun_s: float) -> None:
        """A position with this letter was tried and not reached."""
        for mark in self.runs.marks_met(letter):
            self._tries[mark] += 1
            if self._tries[mark] >= MAX_TRIES:
                self.since_s[mark] = begun_s

    def read(self, letter: Letter, reached_s: float) -> bool:
        """Reads one more position. Returns whether it violates the conjunct for the first time."""
        could_hold = bool(self.runs.states) or not self.letters  # one that never can is told
        self.since_s = self.since_with(letter, reached_s)
        for mark in self.runs.marks_met(letter):
            self._tries[mark] = 0
            self.left_to_meet -= {mark}
        self.runs = self.runs.after(letter)
        self.letters.append(letter)
        return could_hold and not self.runs.states
