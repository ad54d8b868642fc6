"""The events of a mission as values; event_entries.py reads them."""

from __future__ import annotations

from dataclasses import dataclass

from companion.mission.facts import Fact
from companion.mission.signals import AnyCondition


@dataclass(frozen=True, slots=True)
class Event:
    """A fact that the vehicle cannot choose; it comes from received messages (Section III-B).

    It becomes true when `when` has held for `for_s`. It becomes false when `until` (default: not
    `when`) has held for `for_s`, or never if `latch`. A command has no duration: it counts at once.
    A signal that was not heard for `stale_s` is unknown: it changes nothing, except where the
    condition is silence.
    When the event becomes true, the conjuncts named in `restarts` start again, and what they still
    demanded because of earlier positions is dropped; withdrawn beliefs with a predicate in
    `restores` are held again.
    """

    name: str
    when: AnyCondition
    until: AnyCondition | None
    latch: bool
    for_s: float
    restarts: frozenset[str]
    restores: frozenset[str] = frozenset()
    stale_s: float | None = None

    @property
    def fact(self) -> Fact:
        """The fact that holds while the event is true."""
        return Fact(self.name)

    @property
    def is_pulse(self) -> bool:
        """Whether the event becomes false again at the moment at which it becomes true."""
        return self.when.signal.is_pulse and self.until is None and not self.latch

    @property
    def duration(self) -> str:
        """How long the event is true, in words."""
        if self.is_pulse:
            return f"at the moment of {self.when}, once in the word for each"
        delay = f"; a change counts after {self.for_s:g} s" if self.for_s else ""
        if self.latch:
            return f"for ever, once {self.when}{delay}"
        span = f"from {self.when} until {self.until}" if self.until else f"while {self.when}"
        return span + delay
