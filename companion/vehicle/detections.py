"""Reports of other programs on board, such as detectors: one datagram, one JSON object.

    {"persons": 2, "door_open": true}

Each key is the name of a signal that the mission's events mention, `EVENT[persons]`, each value a
number or a truth; or a position, where a place is found by it:

    {"person": {"forward_m": 4.5, "right_m": -1.2, "monotonic_ns": 81234567890123}}

What is not so is dropped, counted and told; nothing in a datagram can raise.

Rules:
1. A datagram has at most LONGEST bytes, and in a tick MOST are read; more wait for the next.
2. Of a signal that is reported several times in a tick the last value counts.
3. A name that the mission does not mention is passed over, and told once for each.
4. Numbers that are not finite are none.
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
"""Of a flight: a program that reports something else each time fills no log."""


class Detections:
    """Reads the reports of one flight.

    Args:
        signals: what the mission's events mention.
        placed: the names of those that find places.
    """

    def __init__(self, signals: Iterable[Signal], placed: Collection[str] = ()) -> None:
        self._sightings: dict[str, Sighting] = {}
        self._placed = placed
        self._signals = {signal.instance: signal for signal in signals if signal.is_report}
        self._told: set[str] = set()
        self._refused = self._refused_told = 0
        self._news: list[FlightEvent] = []

    def read(self, datagrams: Sequence[bytes]) -> list[SignalReading]:
        """What the reports of a tick say, the last value of each signal."""
        values: dict[Signal, float] = {}
        for datagram in datagrams:
            for name, value in self._object(datagram).items():
                signal, number = self._signals.get(name), _number(value)
                if signal is None:
                    self._pass_over(name)
                elif name in self._placed:
                    self._see(name, value)
                elif number is None:
                    self.refuse(f"{name} is no number and no truth: {_short(value)}")
                else:
                    values[signal] = number
        return list(values.items())

    def news(self) -> list[FlightEvent]:
        """What was refused since this was asked, when that is news."""
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
        """What finds a place; numbers that say that nothing is there are passed over."""
        if _number(value) == 0.0:
            return
        seen = sighting_of(value) if isinstance(value, dict) else None
        if seen is None or isinstance(seen, Refusal):
            why = seen.reason if seen is not None else "it finds a place, and needs a position"
            self.refuse(f"{name}: {why}")
        else:
            self._sightings[name] = seen

    def take_sightings(self) -> dict[str, Sighting]:
        """The positions that were reported since this was asked, the last one of each name."""
        sightings, self._sightings = self._sightings, {}
        return sightings

    def refuse(self, why: str) -> None:
        """A report cannot be used; told when that is news."""
        self._refused += 1
        if is_news(self._refused, self._refused_told):
            self._refused_told = self._refused
            self._news.append(ReportRefused(why, self._refused))

    def _pass_over(self, name: str) -> None:
        if name in self._told or len(self._told) >= MOST_NAMES_TOLD:
            return
        self._told.add(name)
        known = ", ".join(sorted(self._signals)) or "none"
        self._news.append(ReportUnknown(_short(name), known))


def _number(value: object) -> float | None:
    """A finite number, or a truth as 0 or 1."""
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
