"""The word of a flight with its times, as the clock of a line with a time bound reads it.

In: changes of events and positions that were left, in the order of the record. Out: the positions
after which the clock had run out. A position counts from the moment at which it is reached,
although its record comes when it is left. Between two positions the vehicle is at none, and events
that become true are remembered.

Time counts from the first position until the end begins: the requested flight home, the landing, or
the last line of a run that was cut off.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from companion.flight_events.facts import MissionEventChanged
from companion.flight_events.plans import LineTakenUp
from companion.flight_events.word import PositionLeft
from companion.ltl.bound_clock import BoundClock
from companion.ltl.patterns import AT
from companion.ltl.semantics import Letter
from companion.ltl.time_bounds import TimeBound

_NEVER_MS = 1 << 62

Step = MissionEventChanged | PositionLeft | LineTakenUp
"""What the record says about the word in time."""


@dataclass(frozen=True, slots=True)
class TimedWord:
    """A flight, as clocks read it.

    Attributes:
        steps: changes of events, positions left, and lines taken up, each with its time.
        until_s: when time ceased to count.
        told: lines, and the positions after which the flight itself reported that their clocks had
            run out.
    """

    steps: tuple[tuple[float, Step], ...]
    until_s: float
    told: frozenset[tuple[str, int]] = frozenset()

    def overruns(self, bound: TimeBound, name: str, restarts: bool = True) -> tuple[int, ...]:
        """The positions after which the clock of a bound had run out.

        At most one, and at most one more after each restart.

        Args:
            bound: the bound of the line.
            name: the name of the line.
            restarts: whether the line restarts where the record says so.
        """
        restarted = self._restarted_at(name) if restarts else frozenset()
        reader = _Reader(BoundClock(bound), self._positions(), self._events_at_first())
        for number, (time_s, step) in enumerate(self.steps):
            if not reader.is_at_the_end:
                reader.run(_ms(time_s))
            if number in restarted:
                reader.restart()
            if isinstance(step, MissionEventChanged):
                reader.change(step, _ms(time_s))
            elif isinstance(step, PositionLeft):
                reader.leave(step, _ms(time_s))
        return tuple(reader.after(_ms(self.until_s), (name, reader.last) in self.told))

    def _restarted_at(self, name: str) -> frozenset[int]:
        """The steps at which a line restarts, as recorded by the next position that is left.

        It restarts when it is taken up again, or at the last event that has become true and
        restarts it.
        """
        found, rise, taken_up = set[int](), None, None
        for number, (_, step) in enumerate(self.steps):
            match step:
                case MissionEventChanged(holds=True):
                    rise = number
                case LineTakenUp(line=line, anew=True) if line == name:
                    taken_up = number
                case PositionLeft():
                    if name in step.restarted:
                        found.add(next(n for n in (taken_up, rise, number) if n is not None))
                    rise = taken_up = None
        return frozenset(found)

    def _events_at_first(self) -> dict[str, bool]:
        """The events that change, and whether they were true at the start."""
        changes = [step for _, step in self.steps if isinstance(step, MissionEventChanged)]
        return {change.event: not change.holds for change in reversed(changes)}

    def _positions(self) -> Iterator[PositionLeft]:
        return (step for _, step in self.steps if isinstance(step, PositionLeft))


class _Reader:
    """Reads a word with one clock.

    Attributes:
        found: the positions after which it had run out.
        last: the position that was left last.

    Args:
        clock: the clock of the bound.
        positions: in their order.
        events: those that change, and whether they are true at the start.
    """

    def __init__(
        self, clock: BoundClock, positions: Iterator[PositionLeft], events: dict[str, bool]
    ) -> None:
        self.found: list[int] = []
        self._positions = positions
        self._clock = clock
        self._next = next(positions, None)  # to be reached next
        self._here: PositionLeft | None = None  # reached, and not left yet
        self._there: Letter = frozenset()  # what was true at the position left last, without places
        self.last = 0
        self._events = events
        self._risen: set[str] = set()
        self._begun_ms = 0
        if self._next is not None:
            self._begun_ms = _ms(self._next.reached_s)
            self._clock = clock.begun(self._begun_ms)

    @property
    def is_at_the_end(self) -> bool:
        """Whether the position where the vehicle is now is not recorded any more."""
        return self._here is None and self._next is None

    def run(self, now_ms: int) -> None:
        """Advances time; a position may be reached meanwhile."""
        if self._here is None and self._next is not None:
            reached_ms = _ms(self._next.reached_s)
            if reached_ms <= now_ms:
                self._look(reached_ms)
                self._here = self._next
                self._next = next(self._positions, None)
                self._clock = self._clock.seeing(self._letter)
        self._look(now_ms)

    def after(self, now_ms: int, is_told: bool) -> list[int]:
        """All positions found, including those after the last one that was left.

        What was reached since then is not recorded, so the flight's own report is used for it.
        """
        is_over = self._clock.is_over(now_ms, None)
        return [*self.found, self.last] if is_over and is_told else self.found

    def restart(self) -> None:
        """Restarts with the next position that is left."""
        self._clock = self._clock.restarted()

    def change(self, event: MissionEventChanged, now_ms: int) -> None:
        """Notes a change of an event; one from before the task belongs to its first letter."""
        self._events[event.event] = event.holds
        if event.holds:
            self._risen.add(event.event)
        if now_ms >= self._begun_ms:
            self._clock = self._clock.seeing(self._letter, now_ms)

    def leave(self, position: PositionLeft, now_ms: int) -> None:
        """Notes that a position was left."""
        letter = frozenset(position.facts)
        was_late = self._clock.is_late
        self._clock = self._clock.after(letter, _ms(position.reached_s), now_ms)
        if self._clock.is_late and not was_late:
            self.found.append(position.number)
        self._there = frozenset(f for f in letter if not f.startswith(f"{AT}("))
        self._here, self.last = None, position.number
        self._risen.clear()
        self._clock = self._clock.seeing(self._letter)

    def _look(self, now_ms: int) -> None:
        unread = self._letter if self._here is not None else None
        if self._clock.is_over(now_ms, unread):
            self._clock = self._clock.over()
            self.found.append(self.last)

    @property
    def _letter(self) -> Letter:
        """The next letter, as far as it is known now."""
        facts = self._there if self._here is None else frozenset(self._here.facts)
        events = {name for name, holds in self._events.items() if holds} | self._risen
        return (facts - self._events.keys()) | events


def _ms(seconds: float) -> int:
    return round(1000 * seconds)
