"""Limits for a mission that never ends by itself."""

from __future__ import annotations

from dataclasses import dataclass

from companion.acting.flight import Flight
from companion.errors import RequestError
from companion.flight_events.sortie import EndedAtLimit


@dataclass(frozen=True, slots=True)
class FlightLimit:
    """When a mission is called home.

    >>> limit = FlightLimit(laps=3, duration_s=600.0)
    >>> limit.reached(2, 599.0), limit.reached(3, 100.0), limit.reached(0, 600.0)
    (None, '3 laps', '600 s')

    Attributes:
        laps: number of laps of the task, over all its plans that do not end; a lap meets everything
            that has to be met again and again. None for no limit.
        duration_s: seconds since the vehicle was to arm; None for no limit.

    Raises:
        RequestError: the limit is reached before the flight begins.
    """

    laps: int | None = None
    duration_s: float | None = None

    def __post_init__(self) -> None:
        """Refuses limits that are reached before the flight begins."""
        if self.laps is not None and self.laps < 1:
            raise RequestError(f"{self.laps} laps is not a limit of a flight; give 1 or more")
        if self.duration_s is not None and not self.duration_s > 0:
            raise RequestError(
                f"{self.duration_s:g} s is not a limit of a flight; give more than 0"
            )

    def reached(self, laps: int, flown_s: float) -> str | None:
        """The limit that is reached, in words; None if none is."""
        if self.laps is not None and laps >= self.laps:
            return f"{self.laps} lap{'s' * (self.laps > 1)}"
        if self.duration_s is not None and flown_s >= self.duration_s:
            return f"{self.duration_s:g} s"
        return None


NO_LIMIT = FlightLimit()
"""For missions that end by themselves or by an operator."""


class LimitWatch:
    """Knows when a flight has reached its limit.

    Attributes:
        called_home_for: the limit for which the vehicle was called home, in words; None before.
    """

    def __init__(self, limit: FlightLimit, flight: Flight) -> None:
        self.called_home_for: str | None = None
        self._limit, self._flight = limit, flight
        self._begun_s = 0.0

    def begin(self, now_s: float) -> None:
        """Notes when the vehicle is to arm, or was to arm."""
        self._begun_s = now_s

    def call_home(self, limit: str) -> None:
        """Notes that the vehicle is called home for a limit."""
        self.called_home_for = limit

    def due(self, laps: int) -> str | None:
        """The limit that is reached after so many laps, in words; None if none is."""
        return self._limit.reached(laps, self._flight.now_s - self._begun_s)

    def ending(self) -> EndedAtLimit | None:
        """How the flight ended, with the status of the task; None if not at its limit."""
        if self.called_home_for is None:
            return None
        task = self._flight.task
        names, dropped = ", ".join(task.violated), ", ".join(sorted(task.lines.dropped))
        verdict = f"{names} violated" if names else "the task holds so far"
        verdict += f", without {dropped}" if dropped else ""
        return EndedAtLimit(self.called_home_for, verdict)
