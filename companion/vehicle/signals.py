"""The numbers on the wire that a mission's events are made of."""

from __future__ import annotations

import math
from collections.abc import Iterable

from companion.mavlink.framing import Message
from companion.mission.signals import Signal

NOT_KNOWN = {("BATTERY_STATUS", "battery_remaining"): -1, ("SYS_STATUS", "battery_remaining"): -1}
"""Values that mean "not known"; they are never handed on as numbers."""

Reading = tuple[Signal, float]
"""A signal and its value."""


class SignalReader:
    """Finds signals in messages.

    Args:
        signals: what to look for.
    """

    def __init__(self, signals: Iterable[Signal]) -> None:
        self._signals: dict[str, list[Signal]] = {}
        for signal in signals:
            self._signals.setdefault(signal.message, []).append(signal)

    @property
    def messages(self) -> frozenset[str]:
        """The names of the messages in which there are any."""
        return frozenset(self._signals)

    def read(self, message: Message) -> list[Reading]:
        """The signals in a message; values that are not known, or not finite, are left out."""
        readings = []
        for signal in self._signals.get(message.get_type(), ()):
            if signal.instance and message.name != signal.instance:
                continue
            value = getattr(message, signal.field)
            if math.isfinite(value) and value != NOT_KNOWN.get((signal.message, signal.field)):
                readings.append((signal, float(value)))
        return readings
