"""Signals, the numbers from which events are made, and conditions on them."""

from __future__ import annotations

import operator
from collections.abc import Callable
from dataclasses import dataclass

COMMAND = "COMMAND"
"""Used in place of a message's name for commands sent to the companion."""

REPORT = "EVENT"
"""Used in place of a message's name for reports of other programs (detections.py)."""

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
    """One number: a field of a MAVLink message, the arrival of a command, or a detector's report.

    Attributes:
        message: MAVLink message name, `COMMAND`, or `REPORT`.
        instance: the `name` field that tells instances apart (NAMED_VALUE_*), or the name in a
            report, else "".
        field: the message's field; for `COMMAND` the MAV_CMD name (its value is 1); else "".
    """

    message: str
    instance: str
    field: str

    @property
    def is_pulse(self) -> bool:
        """Whether it has its value only at the moment of arrival."""
        return self.message == COMMAND

    @property
    def is_battery(self) -> bool:
        """Whether it is about the battery.

        >>> Signal("SYS_STATUS", "", "battery_remaining").is_battery
        True
        """
        is_in_status = self.message == "SYS_STATUS" and "battery" in self.field
        return self.message == "BATTERY_STATUS" or is_in_status

    @property
    def is_report(self) -> bool:
        """Whether another program reports it, instead of MAVLink."""
        return self.message == REPORT

    def __str__(self) -> str:
        instance = f"[{self.instance}]" if self.instance else ""
        field = f".{self.field}" if self.field else ""
        return f"{self.message}{instance}{field}"


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

    def is_met_by(self, value: float | None) -> bool:
        """Whether the condition holds for a value of the signal; never for an unknown value."""
        return value is not None and COMPARISONS[self.comparison](value, self.threshold)


@dataclass(frozen=True, slots=True)
class Silence:
    """A condition: a signal was not heard for `stale_s`, so the event treats it as unknown."""

    signal: Signal

    def __str__(self) -> str:
        return f"{self.signal} is silent"


AnyCondition = Condition | Silence
