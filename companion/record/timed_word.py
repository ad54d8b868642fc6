"""The word of a flight in time: what its positions and events say to the clock of a bounded line.

In goes what the record has in its order: events as they changed, positions as they were left. Out
comes where the clock has run over. A position that was reached counts from then on, although it is
left later; between two positions the vehicle is at none, and what has risen is not forgotten.

Time counts from the first position on until the end begins: the flight home that was asked for,
the landing, or the last line of a run that was cut off.
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
"""What a record has of the word in time."""


@dataclass(frozen=True, slots=True)
class TimedWord:
    """A flight, for clocks.

    Attributes:
        steps: changes of events, positions as they were left, and lines as they were taken up,
            each with its time.
        until_s: when time ceased to count.
        told: lines, and the positions after which their clocks had run over, as the flight told it.
    """

    steps: tuple[tuple[float, Step], ...]
    until_s: float
    told: frozenset[tuple[str, int]] = frozenset()

    def overruns(self, bound: TimeBound, name: str, begins_anew: bool = True) -> tuple[int, ...]:
        """The positions after which the clock of a bound has run over.

        One, and perhaps one more after each time it began anew.

        Args:
            bound: what the line says.
            name: of the line.
            begins_anew: whether it does where the record says so.
        """
        anew = self._anew(name) if begins_anew else frozenset()
        reader = _Reader(BoundClock(bound), self._positions(), self._events_at_first())
        for number, (time_s, step) in enumerate(self.steps):
            if not reader.is_at_the_end:
                reader.run(_ms(time_s))
            if number in anew:
                reader.begin_anew()
            if isinstance(step, MissionEventChanged):
                reader.change(step, _ms(time_s))
            elif isinstance(step, PositionLeft):
                reader.leave(step, _ms(time_s))
        return tuple(reader.after(_ms(self.until_s), (name, reader.last) in self.told))

    def _anew(self, name: str) -> frozenset[int]:
        """The steps at which a line begins anew, which the position left next says.

        It is taken up so; or an event has risen by which it does, the last one that has.
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
        """The events that change, and whether they held before."""
        changes = [step for _, step in self.steps if isinstance(step, MissionEventChanged)]
        return {change.event: not change.holds for change in reversed(changes)}

    def _positions(self) -> Iterator[PositionLeft]:
        return (step for _, step in self.steps if isinstance(step, PositionLeft))


class _Reader:
    """Reads a word with one clock.

    Attributes:
        found: the positions after which it had run over.
        last: the position that was left last.

    Args:
        clock: of the bound.
        positions: in their order.
        events: those that change, and whether they hold at first.
    """

    def __init__(
        self, clock: BoundClock, positions: Iterator[PositionLeft], events: dict[str, bool]
    ) -> None:
        self.found: list[int] = []
        self._positions = positions
        self._clock = clock
        self._next = next(positions, None)  # to be reached
        self._here: PositionLeft | None = None  # reached, and not left yet
        self._there: Letter = frozenset()  # what held at the position left last, but for places
        self.last = 0
        self._events = events
        self._risen: set[str] = set()
        self._begun_ms = 0
        if self._next is not None:
            self._begun_ms = _ms(self._next.reached_s)
            self._clock = clock.begun(self._begun_ms)

    @property
    def is_at_the_end(self) -> bool:
        """Whether what was reached now is not known any more."""
        return self._here is None and self._next is None

    def run(self, now_ms: int) -> None:
        """Time goes on; a position may be reached meanwhile."""
        if self._here is None and self._next is not None:
            reached_ms = _ms(self._next.reached_s)
            if reached_ms <= now_ms:
                self._look(reached_ms)
                self._here = self._next
                self._next = next(self._positions, None)
                self._clock = self._clock.seeing(self._letter)
        self._look(now_ms)

    def after(self, now_ms: int, is_told: bool) -> list[int]:
        """All that is found, after the position that was left last too.

        What was reached since is not known, so that the flight's own word is taken then.
        """
        is_over = self._clock.is_over(now_ms, None)
        return [*self.found, self.last] if is_over and is_told else self.found

    def begin_anew(self) -> None:
        """It begins anew with the position that is left next."""
        self._clock = self._clock.anew()

    def change(self, event: MissionEventChanged, now_ms: int) -> None:
        """An event has changed; one from before the task begins is of its first letter."""
        self._events[event.event] = event.holds
        if event.holds:
            self._risen.add(event.event)
        if now_ms >= self._begun_ms:
            self._clock = self._clock.seeing(self._letter, now_ms)

    def leave(self, position: PositionLeft, now_ms: int) -> None:
        """A position was left."""
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
        """What the next letter will have, as far as it was known."""
        facts = self._there if self._here is None else frozenset(self._here.facts)
        events = {name for name, holds in self._events.items() if holds} | self._risen
        return (facts - self._events.keys()) | events


def _ms(seconds: float) -> int:
    return round(1000 * seconds)
