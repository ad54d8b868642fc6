"""Signals, the numbers on the wire that events are made of, and conditions on them."""

from __future__ import annotations

import operator
from collections.abc import Callable
from dataclasses import dataclass

COMMAND = "COMMAND"
"""Stands in the place of a message's name for commands sent to the companion."""

COMPARISONS: dict[str, Callable[[float, float], bool]] = {
    "<": operator.lt,
    "<=": operator.le,
    ">": operator.gt,
    ">=": operator.ge,
    "==": operator.eq,
    "!=": operator.ne,
}


@dataclass(frozen=True, slots=True)
class Signal:
    """One number on the MAVLink wire: a field of a message, or the arrival of a command.

    Attributes:
        message: MAVLink message name, or `COMMAND`.
        instance: the `name` field that tells instances apart (NAMED_VALUE_*), else "".
        field: the message's field; for `COMMAND` the MAV_CMD name (its value is 1).
    """

    message: str
    instance: str
    field: str

    @property
    def is_pulse(self) -> bool:
        """Whether it has its value at the moment of its arrival alone."""
        return self.message == COMMAND

    def __str__(self) -> str:
        instance = f"[{self.instance}]" if self.instance else ""
        return f"{self.message}{instance}.{self.field}"


@dataclass(frozen=True, slots=True)
class Condition:
    """A comparison of a signal with a constant, e.g. NAMED_VALUE_INT[target].value > 0."""

    signal: Signal
    comparison: str  # one of < <= > >= == !=
    threshold: float

    def __str__(self) -> str:
        if self.signal.is_pulse:
            return str(self.signal)
        return f"{self.signal} {self.comparison} {self.threshold:g}"

    def is_met_by(self, value: float) -> bool:
        """Whether it holds for a value of the signal."""
        return COMPARISONS[self.comparison](value, self.threshold)
