"""Extracts from MAVLink messages the numbers that the mission's events use."""

from __future__ import annotations

import math
from collections.abc import Iterable

from companion.flight_events.event import FlightEvent
from companion.flight_events.reports import SignalOfAnother
from companion.mavlink.framing import Message
from companion.mission.signals import Signal

NOT_KNOWN = {("BATTERY_STATUS", "battery_remaining"): -1, ("SYS_STATUS", "battery_remaining"): -1}
"""Values that mean "not known"; they are never passed on as numbers."""

MOST_TOLD = 20
"""In a flight, so that a sender that uses many system ids does not fill the log."""

SignalReading = tuple[Signal, float]
"""A signal and its value."""


class SignalReader:
    """Finds signals in messages.

    Args:
        signals: those to look for.
    """

    def __init__(self, signals: Iterable[Signal]) -> None:
        self._signals: dict[str, list[Signal]] = {}
        for signal in signals:
            self._signals.setdefault(signal.message, []).append(signal)

    @property
    def messages(self) -> frozenset[str]:
        """The names of the messages that contain signals."""
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
    """Reports signals of the mission that come from a system other than the vehicle's, once each.

    Such a signal is ignored, as a payload has the system id of its vehicle. A payload with another
    id is a mistake that would go unnoticed otherwise: its event never becomes true.

    Args:
        reader: of the mission's signals.
    """

    def __init__(self, reader: SignalReader) -> None:
        self._reader = reader
        self._told: set[tuple[Signal, int]] = set()

    def news(self, vehicle: int, messages: Iterable[Message]) -> list[FlightEvent]:
        """The reports that are new.

        Args:
            vehicle: system id of our vehicle.
            messages: from any system.
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
