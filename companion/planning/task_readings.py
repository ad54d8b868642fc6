"""How far the conjuncts of a task have read the word: automata, clocks, waits and laps.

The task's state says what is read, and when (task_state.py).

1. Every conjunct reads every position that is left; those of a line that is dropped as well.
2. A conjunct that no continuation can satisfy any more is violated by the position read last. No
   plan leads there: it takes an event or a failure that the vehicle could not choose.
3. A bounded line is violated as soon as its clock has run over, by the position left last, and
   told at once. Clocks go on over replans, pauses and takeovers (companion/ltl/bound_clock.py).
4. What has to be met again and again waits since the position that met it last. Once two tries in a
   row were interrupted it waits since the last of them: others may be reached where it is not.
5. A lap of the task is over when every acceptance mark has been met since the lap before, by
   whatever plans. A line that is dropped has no part in it.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass

from companion.planning.bound_clocks import BoundClocks, ClocksRun
from companion.planning.lasso import Conjunct, Letter
from companion.planning.readings import Reading
from companion.slices import spent

_READING_US = 40


@dataclass(frozen=True, slots=True)
class WordSoFar:
    """What a problem has to know of the word; each field has an entry for each conjunct.

    Attributes:
        automaton_states: where the automata may be.
        histories: the letters that were read.
        waiting_since_ms: since when what is to be met again and again waits.
        clocks_ms: what the clocks show; () without bounds.
    """

    automaton_states: tuple[frozenset[int], ...]
    histories: list[list[Letter]]
    waiting_since_ms: tuple[int, ...]
    clocks_ms: tuple[int | None, ...]


class TaskReadings:
    """What the conjuncts of a task have read.

    Attributes:
        violated: the lines that no continuation of it can satisfy.
        laps: how many laps of the task are over.

    Args:
        conjuncts: of the task.
    """

    def __init__(self, conjuncts: Sequence[Conjunct]) -> None:
        self.laps = 0
        self._readings = [Reading(conjunct) for conjunct in conjuncts]
        self._clocks = BoundClocks(conjuncts)
        self._find_violated()

    def _find_violated(self) -> None:
        """After every change of what was read, and of what is late."""
        late = self._clocks.late
        names = (r.conjunct.name for r in self._readings if not r.runs.states or r.conjunct in late)
        self.violated = tuple(dict.fromkeys(names))

    @property
    def have_clocks(self) -> bool:
        """Whether a conjunct has a bound in time."""
        return bool(self._clocks)

    @property
    def have_begun(self) -> bool:
        """Whether the clocks run."""
        return self._clocks.are_begun

    def read(
        self, letter: Letter, reached_s: float, left_s: float, dropped: Collection[str]
    ) -> tuple[Conjunct, ...]:
        """One more position; the conjuncts that it violates, which were not violated before.

        Args:
            letter: what holds there.
            reached_s: when the vehicle has come there.
            left_s: when it leaves.
            dropped: lines that have no part in laps.
        """
        late = self._clocks.read(letter, reached_s, left_s)
        violated = tuple(r.conjunct for r in self._readings if r.read(letter, reached_s))
        self._find_violated()
        self._count_lap(dropped)
        return violated + tuple(conjunct for conjunct in late if conjunct not in violated)

    def _count_lap(self, dropped: Collection[str]) -> None:
        kept = [r for r in self._readings if r.conjunct.name not in dropped]
        if kept and not any(r.left_to_meet for r in kept):
            self.laps += 1
            for reading in self._readings:
                reading.begin_lap()

    def restart(self, line: str, now_s: float) -> bool:
        """A line begins anew with the position that is left next; whether the task has it."""
        own = [reading for reading in self._readings if reading.conjunct.name == line]
        for reading in own:
            reading.restart(now_s)
        self._clocks.begin_anew(line)
        self._find_violated()
        return bool(own)

    def run_clocks(self, now_s: float, unread: Letter | None) -> ClocksRun:
        """Time goes on. See `BoundClocks.run`."""
        run = self._clocks.run(now_s, unread)
        if run.over:
            self._find_violated()
        return run

    def foresee(self, letter: Letter, event_s: float | None = None) -> None:
        """What will be read next, as far as it is known. See `BoundClocks.see`."""
        self._clocks.see(letter, event_s)

    def try_in_vain(self, letter: Letter, begun_s: float) -> None:
        """A position with this letter was not reached."""
        for reading in self._readings:
            reading.try_in_vain(letter, begun_s)

    def are_called(self, lines: Collection[str]) -> bool:
        """Whether an event asks for the goal of one of some lines, and no position has read it."""
        return self._clocks.are_called(lines)

    def so_far(
        self, unread: Letter | None, reached_s: float, now_s: float, anew: Collection[str]
    ) -> WordSoFar:
        """The word with the present position, as if that were read.

        Args:
            unread: what holds there; None if it was read.
            reached_s: when the vehicle has come there.
            now_s: the time, which clocks show.
            anew: lines that begin anew there.
        """
        spent(_READING_US * len(self._readings))
        readings = [r.anew(reached_s) if r.conjunct.name in anew else r for r in self._readings]
        if unread is None:
            states = tuple(r.runs.states for r in readings)
            histories = [r.letters for r in readings]
            waiting = [r.since_s for r in readings]
            present = None
        else:
            states = tuple(r.runs.after(unread).states for r in readings)
            histories = [[*r.letters, unread] for r in readings]
            waiting = [r.since_with(unread, reached_s) for r in readings]
            present = (unread, reached_s)
        return WordSoFar(
            self._clocks.without_late(states, anew),
            histories,
            tuple(round(1000 * min(marks, default=0.0)) for marks in waiting),
            self._clocks.show(now_s, present, anew),
        )
