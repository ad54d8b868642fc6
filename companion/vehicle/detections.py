"""Reads reports of other programs on board, such as detectors: each datagram is one JSON object.

    {"persons": 2, "door_open": true}

Each key names a signal that the mission's events use, as `EVENT[persons]`. Its value is a number or
a truth value. If a place is found by the signal, it is a position, or 0 if nothing is seen:

    {"person": {"forward_m": 4.5, "right_m": -1.2, "monotonic_ns": 81234567890123}}

Anything else is dropped, counted and reported. No datagram can raise an exception.

Rules:
1. A datagram has at most LONGEST bytes. At most MOST are read in a tick; the others wait.
2. If a signal is reported several times in a tick, the last value counts.
3. A name that the mission does not use is ignored, and reported once.
4. Infinity and NaN are not accepted as numbers.
"""

from __future__ import annotations

import json
import math
from collections.abc import Collection, Iterable, Sequence

from companion.errors import printable
from companion.flight_events.event import FlightEvent
from companion.flight_events.reports import ReportRefused, ReportUnknown
from companion.mavlink.intake import is_news
from companion.mission.signals import Signal
from companion.outcomes import Refusal
from companion.vehicle.sightings import Sighting, sighting_of
from companion.vehicle.signals import SignalReading

LONGEST = 1024
MOST = 200
MOST_NAMES_TOLD = 20
"""In a flight, so that a program which reports a new name each time does not fill the log."""


class Detections:
    """Reads the reports of one flight.

    Args:
        signals: those that the mission's events use.
        placed: names of the signals that find places.
    """

    def __init__(self, signals: Iterable[Signal], placed: Collection[str] = ()) -> None:
        self._sightings: dict[str, Sighting] = {}
        self._placed = placed
        self._signals = {signal.instance: signal for signal in signals if signal.is_report}
        self._told: set[str] = set()
        self._refused = self._refused_told = 0
        self._news: list[FlightEvent] = []

    def read(self, datagrams: Sequence[bytes]) -> list[SignalReading]:
        """The signals that the reports of a tick contain, with their last values."""
        values: dict[Signal, float] = {}
        for datagram in datagrams:
            for name, value in self._object(datagram).items():
                signal, number = self._signals.get(name), _number(value)
                if signal is None:
                    self._pass_over(name)
                elif name in self._placed and number != 0.0:  # 0: nothing is seen
                    self._see(name, value)
                elif number is None:
                    self.refuse(f"{name} is neither a number nor a truth value: {_short(value)}")
                else:
                    values[signal] = number
        return list(values.items())

    def news(self) -> list[FlightEvent]:
        """What was refused since the last call, if it is worth reporting."""
        news, self._news = self._news, []
        return news

    def _object(self, datagram: bytes) -> dict[str, object]:
        if len(datagram) > LONGEST:
            self.refuse(f"longer than {LONGEST} bytes")
            return {}
        try:
            report = json.loads(datagram)
        except (ValueError, RecursionError):
            self.refuse(f"no JSON: {_short(datagram)}")
            return {}
        if not isinstance(report, dict):
            self.refuse(f"no JSON object: {_short(report)}")
            return {}
        return report

    def _see(self, name: str, value: object) -> None:
        """Keeps a position."""
        seen = sighting_of(value) if isinstance(value, dict) else None
        if seen is None or isinstance(seen, Refusal):
            why = seen.reason if seen is not None else "it finds a place, and needs a position"
            self.refuse(f"{name}: {why}")
        else:
            self._sightings[name] = seen

    def take_sightings(self) -> dict[str, Sighting]:
        """The positions reported since the last call, the last one for each name."""
        sightings, self._sightings = self._sightings, {}
        return sightings

    def refuse(self, why: str) -> None:
        """Counts a report that cannot be used, and reports it if it is news."""
        self._refused += 1
        if is_news(self._refused, self._refused_told):
            self._refused_told = self._refused
            self._news.append(ReportRefused(why, self._refused))

    def _pass_over(self, name: str) -> None:
        if name in self._told or len(self._told) >= MOST_NAMES_TOLD:
            return
        self._told.add(name)
        self._news.append(ReportUnknown(_short(name), tuple(sorted(self._signals))))


def _number(value: object) -> float | None:
    """A finite number; a truth value gives 0 or 1."""
    if not isinstance(value, int | float):
        return None
    try:
        number = float(value)
    except OverflowError:
        return None
    return number if math.isfinite(number) else None


def _short(value: object) -> str:
    text = value.decode(errors="replace") if isinstance(value, bytes) else str(value)
    return printable(text[:40])
