"""The phases that pursue a goal of the vehicle: armed, airborne, in OFFBOARD, on hold, landed.

A goal is pursued until it is observed. If it is not, the vehicle may be left in the air; then the
reason says who controls it.
"""

from __future__ import annotations

from abc import ABC
from typing import ClassVar

from companion.acting.flight import Flight
from companion.acting.landing_wait import LandingWait
from companion.acting.sortie.ending import last_resort
from companion.acting.sortie.flown_task import FlownTask
from companion.acting.sortie.phase_work import PhaseEnd
from companion.acting.sortie.phases import GOALS, SortieEvent
from companion.errors import Aborted
from companion.flight_events.sortie import GoalFailed, Phase
from companion.outcomes import Failed, Progress
from companion.vehicle.ports.state import VehicleState


class GoalPhase(ABC):
    """A phase that pursues a goal.

    Args:
        flight: the flight whose vehicle pursues it.
    """

    phase: ClassVar[Phase]

    def __init__(self, flight: Flight) -> None:
        self._flight = flight

    def tick(self, state: VehicleState) -> PhaseEnd | None:
        """Pursues the goal once the vehicle is ready for it."""
        if self._prepare() is Progress.RUNNING:
            return None
        outcome = self._flight.vehicle.goals.pursue(GOALS[self.phase])
        if isinstance(outcome, Failed):
            reason = outcome.reason + last_resort(self.phase, state)
            self._flight.report(GoalFailed(reason))
            return PhaseEnd(SortieEvent.FAILED, Aborted(reason))
        return PhaseEnd(self._reached) if outcome is Progress.DONE else None

    def _prepare(self) -> Progress:
        """What comes before the goal in each tick; RUNNING while the goal has to wait."""
        return Progress.DONE

    @property
    def _reached(self) -> SortieEvent:
        return SortieEvent.REACHED


class Arming(GoalPhase):
    """Arms the vehicle, once the journal is kept."""

    phase = Phase.ARMING

    def _prepare(self) -> Progress:
        return Progress.DONE if self._flight.journal.is_kept else Progress.RUNNING


class TakingOff(GoalPhase):
    """Lets the autopilot take off."""

    phase = Phase.TAKE_OFF


class EnteringOffboard(GoalPhase):
    """Enters OFFBOARD, with setpoints that hold the vehicle where it is.

    Args:
        flight: the flight.
        flown: what continues in OFFBOARD.
    """

    phase = Phase.OFFBOARD

    def __init__(self, flight: Flight, flown: FlownTask) -> None:
        super().__init__(flight)
        self._flown = flown

    def _prepare(self) -> Progress:
        self._flight.guidance.hold_here()  # it may still rise
        return Progress.DONE

    @property
    def _reached(self) -> SortieEvent:
        return self._flown.goes_on


class Holding(GoalPhase):
    """Brings the vehicle to hold, before it lands."""

    phase = Phase.HOLDING

    def _prepare(self) -> Progress:
        self._flight.guidance.hold()  # until the autopilot does
        return Progress.DONE


class Parting(Holding):
    """Leaves the vehicle on hold, for the pilot."""

    phase = Phase.PARTING


class Landing(GoalPhase):
    """Lets the autopilot land the vehicle, once it swings no longer towards a wall."""

    phase = Phase.LANDING

    def __init__(self, flight: Flight) -> None:
        super().__init__(flight)
        self._wait = LandingWait(flight)

    def _prepare(self) -> Progress:
        if self._wait.tick() is Progress.RUNNING:
            return Progress.RUNNING
        self._flight.guidance.hold()  # until the autopilot does
        return Progress.DONE
