"""Pursues the goal of a phase: armed, airborne, in OFFBOARD, on hold, landed."""

from __future__ import annotations

from companion.acting.flight import Flight
from companion.acting.landing_wait import LandingWait
from companion.acting.phases import GOALS
from companion.flight_events.sortie import Phase
from companion.outcomes import Outcome, Progress


class PhaseGoals:
    """The goals of one sortie.

    Args:
        flight: the flight whose vehicle pursues them.
    """

    def __init__(self, flight: Flight) -> None:
        self._flight, self._landing_wait = flight, LandingWait(flight)

    def tick(self, phase: Phase) -> Outcome:
        """One tick in a phase with a goal; the setpoints meanwhile hold the vehicle."""
        flight = self._flight
        is_held = phase is Phase.LANDING and self._landing_wait.tick() is Progress.RUNNING
        if is_held or (phase is Phase.ARMING and not flight.journal.is_kept):
            return Progress.RUNNING
        if phase is Phase.OFFBOARD:
            flight.guidance.hold_here()  # it may still rise
        elif phase in (Phase.HOLDING, Phase.PARTING, Phase.LANDING):
            flight.guidance.hold()  # until the autopilot does
        return flight.vehicle.goals.pursue(GOALS[phase])
