"""Checks, before arming, that the charge of the battery is known, if plans need it."""

from __future__ import annotations

from companion.acting.flight import Flight
from companion.acting.sortie.preflight.failsafe_check import ANSWER_TIMEOUT_S
from companion.outcomes import Failed, Outcome, Progress

UNKNOWN = (
    "the autopilot does not report the charge of its battery, so it is not armed\n"
    "    battery: plans of this mission use it; set up the autopilot's battery monitor "
    "(PX4: BAT1_SOURCE, BAT1_CAPACITY), or leave the section battery out"
)


class GaugeCheck:
    """One check.

    Args:
        flight: the flight.
    """

    def __init__(self, flight: Flight) -> None:
        self._flight = flight
        self._asked_s: float | None = None

    def tick(self) -> Outcome:
        """DONE when a charge has been reported."""
        state, now_s = self._flight.vehicle.state, self._flight.now_s
        if state is not None and state.battery.percent is not None:
            return Progress.DONE
        if self._asked_s is None:
            self._asked_s = now_s
        is_late = now_s - self._asked_s > ANSWER_TIMEOUT_S
        return Failed(UNKNOWN) if is_late else Progress.RUNNING
