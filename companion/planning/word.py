"""The word of a flight: its positions, and what the automata read at them.

1. The last position is the one where the vehicle is. The automata read it when the vehicle leaves
   it, that is, when the next skill begins. Until then an event may still change it.
2. No event is missed: a letter contains each event that is true when it is read, or that has become
   true since the letter before was read.

The task's state decides when a position is left and which one follows (task_state.py);
task_readings.py keeps what the conjuncts have read.
"""

from __future__ import annotations

from collections.abc import Collection

from companion.mission.events import Event
from companion.mission.facts import Fact
from companion.planning.bound_clocks import NOTHING_OVER, ClocksRun
from companion.planning.en_route import places
from companion.planning.held_beliefs import HeldBeliefs
from companion.planning.lasso import Letter
from companion.planning.planner import Planner
from companion.planning.situation import Position
from companion.planning.task_readings import TaskReadings, WordSoFar


class Word:
    """The positions of a word, and what was read at them.

    Attributes:
        positions: number of positions that have been left.
        left: those of them that nobody has collected yet.
        is_read: whether the vehicle has left the last position and has reached no other one.
        risen: events that have risen since the last letter was read.
        now_s: the time; 0 before the task is flown.

    Args:
        planner: knows the task, and what may be believed.
        beliefs: the beliefs that are held.
    """

    def __init__(self, planner: Planner, beliefs: HeldBeliefs) -> None:
        self._planner, self._beliefs = planner, beliefs
        self._readings = TaskReadings(planner.conjuncts)
        self.positions = 0
        self.left: list[Position] = []
        self.is_read = False
        self.risen = frozenset[Fact]()
        self._restarted: tuple[str, ...] = ()
        self.now_s = self._reached_s = 0.0

    @property
    def last_position(self) -> int:
        """The number of the position that was left last."""
        return max(0, self.positions - 1)

    @property
    def laps(self) -> int:
        """The number of completed laps of the task."""
        return self._readings.laps

    @property
    def violated(self) -> tuple[str, ...]:
        """The lines that no continuation of the word can satisfy."""
        return self._readings.violated

    @property
    def is_called(self) -> bool:
        """Whether the event of a ready line has come, and no position has read it yet."""
        return self._readings.are_called(self._planner.mission.ready)

    def read(self, facts: frozenset[Fact], dropped: Collection[str]) -> None:
        """Lets the automata read the last position, once.

        Args:
            facts: what holds there, without the beliefs.
            dropped: the lines that the present plan does not keep.
        """
        if self.is_read:
            return
        letter = self._letter(facts)
        violated = self._readings.read(letter, self._reached_s, self.now_s, dropped)
        known = facts | letter & self._planner.task_facts
        self.left.append(
            Position(
                number=self.positions,
                facts=known,
                risen=(self.risen - facts) & known,
                reached_s=self._reached_s,
                withdrawn=self._beliefs.withdrawn,
                restarted=self._restarted,
                violated=violated,
                dropped=tuple(n for n in self._planner.mission.task if n in dropped),
            )
        )
        self.positions += 1
        self.risen = frozenset()
        self._restarted = ()
        self.is_read = True
        self._beliefs.read()
        self._foresee(facts)

    def append(self, facts: frozenset[Fact], reached_s: float) -> None:
        """Appends a position where these facts hold."""
        self._reached_s, self.is_read = reached_s, False
        self._foresee(facts)

    def try_in_vain(self, facts: frozenset[Fact]) -> None:
        """A position with these facts was tried and not reached."""
        self._readings.try_in_vain(self._letter(facts), self._reached_s)

    def take(self, event: Event, holds: bool, facts: frozenset[Fact]) -> None:
        """An event has changed, so that these facts hold; lines may start again with it."""
        if holds:
            self.risen |= {event.fact}
        self._foresee(facts, self.now_s)
        for line in self._planner.mission.task:
            if holds and line in event.restarts:
                self.restart(line)

    def restart(self, line: str) -> None:
        """A line starts again at the position that is left next."""
        if self._readings.restart(line, self._reached_s):
            self._restarted = tuple(dict.fromkeys((*self._restarted, line)))

    def run_clocks(self, now_s: float, facts: frozenset[Fact]) -> ClocksRun:
        """Lets time pass. Returns which clocks have just run out.

        The first call begins the task: its first position counts as reached then.
        """
        readings = self._readings
        if not readings.have_clocks:
            return NOTHING_OVER
        if not readings.have_begun and not self.positions:
            self._reached_s = now_s
        self.now_s = now_s
        return readings.run_clocks(now_s, None if self.is_read else self._letter(facts))

    def so_far(
        self, facts: frozenset[Fact], clocks_show_s: float, restarted: Collection[str]
    ) -> WordSoFar:
        """The word including the last position, as if it were read now.

        Args:
            facts: what is assumed to hold there.
            clocks_show_s: the time that clocks show.
            restarted: lines that are assumed to start again there.
        """
        letter = None if self.is_read else self._letter(facts)
        return self._readings.so_far(letter, self._reached_s, clocks_show_s, restarted)

    def _foresee(self, facts: frozenset[Fact], event_s: float | None = None) -> None:
        """Notes what is read next, as far as it is known; between places, the vehicle is at none.

        Args:
            facts: what holds now.
            event_s: when an event has just changed; None if none has.
        """
        letter = self._letter(facts - places(facts) if self.is_read else facts)
        self._readings.foresee(letter, event_s)

    def _letter(self, facts: frozenset[Fact]) -> Letter:
        """What the automata read at a position with these facts."""
        beliefs = self._planner.actions.model.beliefs - self._beliefs.withdrawn
        return facts | self.risen | beliefs
