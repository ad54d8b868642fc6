"""How far the conjuncts of a task have read the word: automata, clocks, waits and laps.

word.py decides what is read, and when.

1. Every conjunct reads every position that is left, also if its line is dropped.
2. A conjunct that no continuation can satisfy is violated by the position read last. No plan leads
   there: an event or a failure that the vehicle could not choose is the cause.
3. A bounded line is violated as soon as its clock has run out, by the position left last, and this
   is reported at once. Clocks run on during replans, pauses and takeovers
   (companion/ltl/bound_clock.py).
4. An acceptance mark waits since the position that met it last. After two tries in a row were
   interrupted, it waits since the last of them, because others may be reachable where it is not.
5. A lap of the task is complete when every acceptance mark has been met since the previous lap, by
   whatever plans. A dropped line does not count.
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
    """What a problem needs to know of the word; each field has an entry for each conjunct.

    Attributes:
        automaton_states: the possible states of the automata.
        histories: the letters that were read.
        waiting_since_ms: since when the longest-waiting acceptance mark waits.
        clocks_ms: what the clocks show; () without bounds.
    """

    automaton_states: tuple[frozenset[int], ...]
    histories: list[list[Letter]]
    waiting_since_ms: tuple[int, ...]
    clocks_ms: tuple[int | None, ...]


class TaskReadings:
    """What the conjuncts of a task have read.

    Attributes:
        violated: the lines that no continuation of the word can satisfy.
        laps: number of completed laps of the task.

    Args:
        conjuncts: the conjuncts of the task.
    """

    def __init__(self, conjuncts: Sequence[Conjunct]) -> None:
        self.laps = 0
        self._readings = [Reading(conjunct) for conjunct in conjuncts]
        self._clocks = BoundClocks(conjuncts)
        self._find_violated()

    def _find_violated(self) -> None:
        """Called after every change of what was read or is late."""
        late = self._clocks.late
        names = (r.conjunct.name for r in self._readings if not r.runs.states or r.conjunct in late)
        self.violated = tuple(dict.fromkeys(names))

    @property
    def have_clocks(self) -> bool:
        """Whether a conjunct has a time bound."""
        return bool(self._clocks)

    @property
    def have_begun(self) -> bool:
        """Whether the clocks run."""
        return self._clocks.are_begun

    def read(
        self, letter: Letter, reached_s: float, left_s: float, dropped: Collection[str]
    ) -> tuple[Conjunct, ...]:
        """Reads one more position. Returns the conjuncts that it violates for the first time.

        Args:
            letter: what holds at the position.
            reached_s: when the vehicle reached it.
            left_s: when the vehicle leaves it.
            dropped: lines that do not count for laps.
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
        """A line starts again at the position that is left next. Returns whether the task has the
        line.
        """
        own = [reading for reading in self._readings if reading.conjunct.name == line]
        for reading in own:
            reading.restart(now_s)
        self._clocks.restart(line)
        self._find_violated()
        return bool(own)

    def run_clocks(self, now_s: float, unread: Letter | None) -> ClocksRun:
        """Lets time pass. See `BoundClocks.run`."""
        run = self._clocks.run(now_s, unread)
        if run.over:
            self._find_violated()
        return run

    def foresee(self, letter: Letter, event_s: float | None = None) -> None:
        """Notes what will be read next, as far as it is known. See `BoundClocks.see`."""
        self._clocks.see(letter, event_s)

    def try_in_vain(self, letter: Letter, begun_s: float) -> None:
        """A position with this letter was tried and not reached."""
        for reading in self._readings:
            reading.try_in_vain(letter, begun_s)

    def are_called(self, lines: Collection[str]) -> bool:
        """Whether an event asks for the goal of one of these lines, and no position has read it
        yet.
        """
        return self._clocks.are_called(lines)

    def so_far(
        self, unread: Letter | None, reached_s: float, now_s: float, restarted: Collection[str]
    ) -> WordSoFar:
        """The word including the present position, as if that were read.

        Args:
            unread: what holds at the present position; None if it has been read.
            reached_s: when the vehicle reached it.
            now_s: the time that clocks show.
            restarted: lines that start again there.
        """
        spent(_READING_US * len(self._readings))
        readings = [
            r.restarted(reached_s) if r.conjunct.name in restarted else r for r in self._readings
        ]
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
            self._clocks.without_late(states, restarted),
            histories,
            tuple(round(1000 * min(marks, default=0.0)) for marks in waiting),
            self._clocks.show(now_s, present, restarted),
        )
