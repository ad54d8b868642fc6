"""The phases that fly in OFFBOARD: the task, a pause of it, and the flight home."""

from __future__ import annotations

from companion.acting.executive import Executive
from companion.acting.executive_states import AwaitingPlan, TaskStatus
from companion.acting.flight import Flight
from companion.acting.safe_places import AtSafePlace, NoSafePlace, SafePlaces, WayToSafePlace
from companion.acting.sortie.flight_limit import LimitWatch
from companion.acting.sortie.flown_task import FlownTask
from companion.acting.sortie.phase_work import PhaseEnd
from companion.acting.sortie.phases import SortieEvent
from companion.errors import Aborted
from companion.flight_events.sortie import (
    FlightLimitReached,
    PauseEnded,
    ReturnBegun,
    ReturnFailed,
)
from companion.mission.otherwise import Otherwise
from companion.outcomes import Failed, Progress
from companion.vehicle.ports.state import VehicleState


class FlyingTask:
    """Flies the task, and to a safe place if the task has no plan.

    Args:
        flight: the flight.
        executive: flies the task.
        flown: what is flown.
        limit: the limit of the flight.
    """

    def __init__(
        self, flight: Flight, executive: Executive, flown: FlownTask, limit: LimitWatch
    ) -> None:
        mission = executive.planner.mission
        self._flight, self._executive, self._flown = flight, executive, flown
        self._limit, self._otherwise = limit, mission.otherwise
        self._safe = SafePlaces(flight, executive.planner, mission.safe_places)

    def tick(self, state: VehicleState) -> PhaseEnd | None:
        """One tick; returns how the task ends, or None while it continues."""
        executive = self._executive
        if self._flown.is_interrupted:
            self._safe.forget()
        if end := self._called_home():
            return end
        is_planned = executive.lasso is not None and not executive.is_leaving
        self._flight.guidance.is_for_task = is_planned
        status = self._flown.fly()
        if status is TaskStatus.SATISFIED:  # with a failure if it has only flown to a safe place
            return PhaseEnd(SortieEvent.SATISFIED, executive.failure)
        is_waiting = executive.is_leaving and isinstance(executive.state, AwaitingPlan)
        is_lost = status is TaskStatus.NO_PLAN or is_waiting
        if not is_lost and not executive.is_leaving:
            self._safe.forget()
        end = self._without_plan(is_waiting) if is_lost else None
        needs_take_off = executive.status is TaskStatus.NEEDS_TAKE_OFF
        return PhaseEnd(SortieEvent.NEEDS_TAKE_OFF) if needs_take_off else end

    def _called_home(self) -> PhaseEnd | None:
        """Calls the vehicle home because of a limit of the flight or a low battery.

        Not while it flies home anyway, and not while it is on the ground by its plan.
        """
        if self._executive.is_leaving or self._flight.progress.is_landed_by_plan:
            return None
        if limit := self._limit.due(self._executive.reports.laps):
            self._limit.call_home(limit)
            self._flight.report(FlightLimitReached(limit))
            self._flown.call_home()
            return PhaseEnd(SortieEvent.CALLED_HOME)
        return self._flown.call_home_for_battery()

    def _without_plan(self, is_waiting: bool) -> PhaseEnd | None:
        """Does what the mission says for the case that no plan exists.

        Args:
            is_waiting: whether the way to a safe place is lost and the vehicle waits for a plan;
                then another safe place is tried first.
        """
        executive, safe, flight = self._executive, self._safe, self._flight
        if executive.is_leaving and safe.place is not None and safe.landed_at is None:
            if executive.way_lost is not None:
                flight.report(ReturnFailed(safe.place, executive.way_lost))
            safe.leave_way(is_blocked=executive.way_lost is not None)
        match safe.decide():
            case AtSafePlace():
                return PhaseEnd(SortieEvent.SATISFIED, executive.failure)
            case WayToSafePlace(place, lasso):
                executive.leave(lasso)
                flight.report(ReturnBegun(place))
            case NoSafePlace() if not is_waiting:
                is_hold = self._otherwise is Otherwise.HOLD
                event = SortieEvent.LEFT_ON_HOLD if is_hold else SortieEvent.OUT_OF_PLANS
                return PhaseEnd(event, executive.failure)
            case None:
                flight.guidance.hold()
        return None


class Paused:
    """Holds the vehicle with the task frozen, or the flight home interrupted.

    Args:
        flight: the flight.
        executive: knows the charge that is needed to land.
        flown: what is paused.
    """

    def __init__(self, flight: Flight, executive: Executive, flown: FlownTask) -> None:
        self._flight, self._flown = flight, flown
        self._energy = executive.planner.energy

    def tick(self, state: VehicleState) -> PhaseEnd | None:
        """One tick; returns how the charge ends the pause, or None."""
        self._flight.guidance.hold()
        is_needed = self._energy is not None and self._energy.is_needed_to_land
        if is_needed or (self._flown.is_called_home and self._flown.is_battery_low):
            self._flight.report(PauseEnded())
            return PhaseEnd(self._flown.end_pause())
        return self._flown.call_home_for_battery()


class FlyingHome:
    """Flies where the vehicle is called.

    Args:
        flight: the flight.
        flown: has the flight home.
        limit: the limit of the flight; a flight that it has called home has done its task.
    """

    def __init__(self, flight: Flight, flown: FlownTask, limit: LimitWatch) -> None:
        self._flight, self._flown, self._limit = flight, flown, limit

    def tick(self, state: VehicleState) -> PhaseEnd | None:
        """One tick; returns how it ended, or None while it continues."""
        self._flight.guidance.is_for_task = False
        home = self._flown.flight_home
        assert home is not None, "called home before this phase"
        outcome = home.tick()
        if outcome is Progress.DONE:
            return PhaseEnd(SortieEvent.SATISFIED)
        if not isinstance(outcome, Failed):
            return None
        failed = ReturnFailed(home.place, outcome.reason)
        self._flight.report(failed)
        is_at_limit = self._limit.called_home_for is not None
        return PhaseEnd(SortieEvent.NO_WAY_HOME, None if is_at_limit else Aborted(failed.text))
