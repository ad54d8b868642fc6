"""Lap profiles: what one lap does to an automaton, from each state in which it may begin.

The profile of a finite word gives, for each state, the states to which the word leads and the marks
met on the way. There are finitely many profiles, and the profile of a word follows from that of the
word without its last letter. So profiles are the states of a deterministic finite automaton that
reads laps. The profile of a lap v tells from which states v v v ... is accepted: those that reach,
lap by lap, a component of states with all marks.

Source: Calbrix, Nivat and Podelski, Ultimately periodic words of rational omega-languages, 1993.
"""

from __future__ import annotations

from collections.abc import Iterable

from companion.ltl.components import reaching, strong_components
from companion.planning.builtin.masked_automaton import MaskedAutomaton
from companion.slices import spent

EMPTY = 0
"""The profile of the empty word."""

MAX_PROFILES = 200
"""The most profiles examined to find how many laps a cycle of the automaton may take."""

_ROW_US = 5

Row = frozenset[tuple[int, int]]
"""The states to which a word leads from one state, each with the marks that some run meets."""


class LapProfiles:
    """The profiles of words over one automaton, numbered in the order of discovery."""

    def __init__(self, automaton: MaskedAutomaton) -> None:
        self._automaton = automaton
        self._rows: list[tuple[Row, ...]] = [
            tuple(frozenset([(state, 0)]) for state in range(automaton.states))
        ]
        self._number_of: dict[tuple[Row, ...], int] = {}  # the empty word has a profile of its own
        self._after: dict[tuple[int, int], int] = {}
        self._accepting: dict[int, frozenset[int]] = {}

    def after(self, profile: int, facts: int) -> int:
        """The profile of a word with the letter of some facts appended."""
        found = self._after.get((profile, facts))
        if found is None:
            rows = tuple(self._read(row, facts) for row in self._rows[profile])
            found = self._number_of.setdefault(rows, len(self._rows))
            if found == len(self._rows):
                self._rows.append(rows)
            self._after[profile, facts] = found
        return found

    def _read(self, row: Row, facts: int) -> Row:
        ends = {
            (after, met | marks)
            for state, met in row
            for after, marks in self._automaton.successors(state, facts)
        }
        return frozenset(
            (state, met)
            for state, met in ends
            if not any(s == state and met & ~more == 0 and met != more for s, more in ends)
        )

    def accepting(self, profile: int) -> frozenset[int]:
        """The states from which a word, repeated for ever, is accepted."""
        found = self._accepting.get(profile)
        if found is None:
            rows = self._rows[profile]
            successors = [[state for state, _ in row] for row in rows]
            components = strong_components(successors)
            has_all_marks = []
            for component in components:
                inside = set(component)
                marks = [m for state in component for end, m in rows[state] if end in inside]
                has_all_marks.append(bool(marks) and self._is_every(*marks))
            found = frozenset(reaching(successors, components, has_all_marks))
            self._accepting[profile] = found
        return found

    def marks(self, profile: int) -> int:
        """The marks that runs meet on a word, from any state."""
        united = 0
        for row in self._rows[profile]:
            for _, met in row:
                united |= met
        return united

    def _is_every(self, *marks: int) -> bool:
        united = 0
        for each in marks:
            united |= each
        return united == self._automaton.every_mark

    def max_laps(self, letters: Iterable[int]) -> int:
        """The most laps that a cycle of the automaton takes, if the lap is accepted.

        Args:
            letters: the facts that laps are made of.

        Returns:
            1 if each accepted lap leads, after some laps, from a state to itself and meets all
            marks; otherwise, or if that is unknown, a number that is never too small.
        """
        if self._has_cycles_of_one_lap(list(letters)):
            return 1
        return self._automaton.states * max(1, self._automaton.every_mark.bit_count())

    def _has_cycles_of_one_lap(self, letters: list[int]) -> bool:
        pending = list(dict.fromkeys(self.after(EMPTY, letter) for letter in letters))
        seen = set(pending)
        for profile in pending:  # grows while it is read
            rows = self._rows[profile]
            spent(_ROW_US * len(rows) * (1 + len(letters)))
            ends = [
                state
                for state, row in enumerate(rows)
                if (state, self._automaton.every_mark) in row
            ]
            reached = set(ends)
            while (
                more := {s for s, row in enumerate(rows) for t, _ in row if t in reached} - reached
            ):
                reached |= more
            if reached != self.accepting(profile):
                return False
            for letter in letters:
                longer = self.after(profile, letter)
                if longer not in seen:
                    seen.add(longer)
                    pending.append(longer)
            if len(seen) > MAX_PROFILES:
                return False
        return True
