"""The numbers on the wire that a mission's events are made of."""

from __future__ import annotations

import math
from collections.abc import Iterable

from companion.flight_events.event import FlightEvent
from companion.flight_events.reports import SignalOfAnother
from companion.mavlink.framing import Message
from companion.mission.signals import Signal

NOT_KNOWN = {("BATTERY_STATUS", "battery_remaining"): -1, ("SYS_STATUS", "battery_remaining"): -1}
"""Values that mean "not known"; they are never handed on as numbers."""

MOST_TOLD = 20
"""Of a flight: who speaks in the names of many systems fills no log."""

SignalReading = tuple[Signal, float]
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

    def read(self, message: Message) -> list[SignalReading]:
        """The signals in a message; values that are not known, or not finite, are left out."""
        readings = []
        for signal in self._signals.get(message.get_type(), ()):
            if signal.instance and message.name != signal.instance:
                continue
            value = getattr(message, signal.field)
            if math.isfinite(value) and value != NOT_KNOWN.get((signal.message, signal.field)):
                readings.append((signal, float(value)))
        return readings


class OtherSystems:
    """Tells once of each signal of the mission that another system than the vehicle says.

    It is passed over: a payload has the system id of its vehicle. One that has not is a mistake
    which nobody would see otherwise: its event just never comes.

    Args:
        reader: of the signals that are asked for.
    """

    def __init__(self, reader: SignalReader) -> None:
        self._reader = reader
        self._told: set[tuple[Signal, int]] = set()

    def news(self, vehicle: int, messages: Iterable[Message]) -> list[FlightEvent]:
        """Which of these were not told before.

        Args:
            vehicle: the system id of our own.
            messages: of anybody.
        """
        found: list[FlightEvent] = []
        for message in messages:
            system = message.get_srcSystem()
            if system == vehicle:
                continue
            for signal, _ in self._reader.read(message):
                if (signal, system) not in self._told and len(self._told) < MOST_TOLD:
                    self._told.add((signal, system))
                    found.append(SignalOfAnother(str(signal), system, vehicle))
        return found
