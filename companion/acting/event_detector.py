"""Detects events: facts that the vehicle cannot choose, made from received readings.

1. An event becomes true when its condition has held for `for_s`. It becomes false when `until` (by
   default the opposite of the condition) has held for as long. So a value that flaps at its
   threshold does not make the fact flap. A latched event stays true.
2. An event that has become false can become true again only after its condition has failed.
3. A command is a pulse: it is true only at the moment of its arrival. So an event may become true
   and false within one tick. If an event flaps within a tick, its last two changes are reported; if
   it became true, that is one of them.
4. A signal that was not heard for the event's `stale_s` is unknown: the event stays as it was,
   unless its condition is silence. Falling silent, and being heard again, are reported, except of
   an event whose condition is silence: its own changes say that.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence

from companion.mission.events import Event
from companion.mission.signals import AnyCondition, Signal, Silence

Change = tuple[str, bool]
"""The name of an event, and whether it is true now."""


class EventDetector:
    """The present value of every event of a mission."""

    def __init__(self, events: Mapping[str, Event]) -> None:
        self._events = events
        self._values: dict[Signal, float] = {}
        self._heard_s: dict[Signal, float] = {}
        self._begun_s: float | None = None
        self._silent: set[str] = set()
        self._since_s: dict[str, float] = {}
        self._holds = dict.fromkeys(events, False)
        self._spent: set[str] = set()  # became false while the condition has held ever since

    @property
    def signals(self) -> frozenset[Signal]:
        """The signals that have to be received."""
        conditions = [c for e in self._events.values() for c in (e.when, e.until) if c]
        return frozenset(c.signal for c in conditions)

    def resume(self, holding: Iterable[str]) -> None:
        """Takes over the events that were true when another process stopped."""
        self._holds |= dict.fromkeys(holding, True)

    def update(self, now_s: float, readings: Iterable[tuple[Signal, float]]) -> list[Change]:
        """Takes readings; returns the changes, at most the last two of each event, in order."""
        changes: list[Change] = []
        if self._begun_s is None:
            self._begun_s = now_s
        for signal, value in readings:
            self._values[signal], self._heard_s[signal] = value, now_s
            changes += self._changes(now_s)
            if signal.is_pulse:
                del self._values[signal]
                changes += self._changes(now_s)
        changes += self._changes(now_s)
        return list(_last_two(changes)) if changes else changes

    def silences(self, now_s: float) -> list[tuple[Event, bool]]:
        """The events whose signal has fallen silent, or is heard again, since the last call.

        An event whose condition is silence is not among them: it changes instead.
        """
        news = []
        for name, event in self._events.items():
            if isinstance(event.when, Silence):
                continue
            is_silent = self._is_stale(event, event.when, now_s)
            if is_silent != (name in self._silent):
                self._silent ^= {name}
                news.append((event, is_silent))
        return news

    def foresee(self, now_s: float, readings: Sequence[tuple[Signal, float]]) -> frozenset[str]:
        """The events that these readings would change; the readings are not taken."""
        if not readings:
            return frozenset()
        trial = EventDetector(self._events)
        trial._values, trial._since_s = self._values.copy(), self._since_s.copy()
        trial._heard_s, trial._begun_s = self._heard_s.copy(), self._begun_s
        trial._holds, trial._spent = self._holds.copy(), self._spent.copy()
        return frozenset(name for name, _ in trial.update(now_s, readings))

    def _changes(self, now_s: float) -> Iterator[Change]:
        for name, event in self._events.items():
            is_met = self._is_met(event, event.when, now_s)
            if not is_met:
                self._spent.discard(name)
            if not self._wants_to_change(event, is_met, now_s):
                self._since_s.pop(name, None)
            elif now_s - self._since_s.setdefault(name, now_s) >= self._delay_s(event):
                del self._since_s[name]
                self._holds[name] = not self._holds[name]
                if is_met and not self._holds[name]:
                    self._spent.add(name)
                yield name, self._holds[name]

    def _wants_to_change(self, event: Event, is_met: bool, now_s: float) -> bool:
        if not self._holds[event.name]:
            return is_met and event.name not in self._spent
        if event.latch:
            return False
        if event.until:
            return self._is_met(event, event.until, now_s)
        if event.when.signal.is_pulse or isinstance(event.when, Silence):
            return not is_met
        return not is_met and self._known(event, event.when, now_s) is not None

    def _delay_s(self, event: Event) -> float:
        """How long a condition that is met has to hold; no time for a pulse."""
        condition = event.until if self._holds[event.name] and event.until else event.when
        return 0.0 if condition.signal.is_pulse else event.for_s

    def _is_met(self, event: Event, condition: AnyCondition, now_s: float) -> bool:
        """Whether a condition of an event holds; silence counts only from `stale_s` on."""
        if isinstance(condition, Silence):
            return self._is_stale(event, condition, now_s)
        return condition.is_met_by(self._known(event, condition, now_s))

    def _known(self, event: Event, condition: AnyCondition, now_s: float) -> float | None:
        """The value for a condition; None if it was never heard, or too long ago."""
        if self._is_stale(event, condition, now_s):
            return None
        return self._values.get(condition.signal)

    def _is_stale(self, event: Event, condition: AnyCondition, now_s: float) -> bool:
        """Whether the signal was not heard for `stale_s`, counted from the beginning if never."""
        begun_s = now_s if self._begun_s is None else self._begun_s
        heard_s = self._heard_s.get(condition.signal, begun_s)
        return event.stale_s is not None and now_s - heard_s > event.stale_s


def _last_two(changes: Sequence[Change]) -> Iterator[Change]:
    """The last two changes of each event, in their order."""
    left = Counter(name for name, _ in changes)
    for name, holds in changes:
        if left[name] <= 2:
            yield name, holds
        left[name] -= 1
