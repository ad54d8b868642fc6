"""Events: facts that the vehicle cannot choose, made from readings off the wire.

An event becomes true when its condition has held for `for_s`, and false when `until` (without
one: the condition's opposite) has held for as long; a latched event stays. So a value that
flaps at its threshold does not make the fact flap.
"""

from __future__ import annotations

import operator
from collections.abc import Callable, Iterable, Mapping

from companion.mission.model import Condition, Event, Signal

COMPARISONS: dict[str, Callable[[float, float], bool]] = {
    "<": operator.lt,
    "<=": operator.le,
    ">": operator.gt,
    ">=": operator.ge,
    "==": operator.eq,
    "!=": operator.ne,
}


class EventDetector:
    """The present value of every event of a mission."""

    def __init__(self, events: Mapping[str, Event]) -> None:
        self._events = events
        self._values: dict[Signal, float] = {}
        self._since_s: dict[str, float] = {}
        self._holds = dict.fromkeys(events, False)

    @property
    def signals(self) -> frozenset[Signal]:
        """What has to be listened for."""
        conditions = [c for e in self._events.values() for c in (e.when, e.until) if c]
        return frozenset(c.signal for c in conditions)

    def update(
        self, now_s: float, readings: Iterable[tuple[Signal, float]]
    ) -> list[tuple[str, bool]]:
        """Takes readings; returns the events that changed, with their new value."""
        before = dict(self._holds)
        for signal, value in readings:
            self._values[signal] = value
            self._change(now_s)
        self._change(now_s)
        return [(name, holds) for name, holds in self._holds.items() if holds != before[name]]

    def _change(self, now_s: float) -> None:
        for name, event in self._events.items():
            if not self._wants_to_change(event):
                self._since_s.pop(name, None)
            elif now_s - self._since_s.setdefault(name, now_s) >= event.for_s:
                del self._since_s[name]
                self._holds[name] = not self._holds[name]

    def _wants_to_change(self, event: Event) -> bool:
        if not self._holds[event.name]:
            return self._is_met(event.when)
        if event.latch:
            return False
        return self._is_met(event.until) if event.until else not self._is_met(event.when)

    def _is_met(self, condition: Condition) -> bool:
        """Whether a condition holds; a signal that was never heard meets none."""
        value = self._values.get(condition.signal)
        compare = COMPARISONS[condition.comparison]
        return value is not None and compare(value, condition.threshold)
