"""Flies in OFFBOARD, either the task or the flight home; can be interrupted and continued.

The executive flies the task, and also the flight to a safe place if the task has no plan. The
vehicle is called home for good by the operator, by a limit of the flight, or by a low battery about
which the mission says nothing. From then on only the flight home is flown, whatever safe places
there are.
"""

from __future__ import annotations

from collections.abc import Sequence

from companion.acting.executive import Executive
from companion.acting.executive_states import AwaitingPlan, TaskStatus
from companion.acting.flight import Flight
from companion.acting.flight_limit import LimitWatch
from companion.acting.journal import EndingBegun
from companion.acting.low_battery import IN_FLIGHT, LowBattery
from companion.acting.phases import SortieEvent
from companion.acting.positions import tell_late
from companion.acting.return_home import ReturnHome
from companion.acting.safe_places import AtSafePlace, NoSafePlace, SafePlaces, WayToSafePlace
from companion.errors import Aborted, CompanionError
from companion.flight_events.sortie import (
    BatteryLow,
    FlightLimitReached,
    PauseEnded,
    Phase,
    ReturnBegun,
    ReturnFailed,
)
from companion.mission.model import Mission
from companion.mission.otherwise import Otherwise
from companion.mission.signals import Signal
from companion.outcomes import Failed, Progress

CLOCKED = (
    Phase.TASK,
    Phase.PAUSED,
    Phase.YIELDED,
    Phase.OFFBOARD,
    Phase.ARMING,
    Phase.TAKE_OFF,
)
"""The phases in which the clocks of the task run, once it has begun."""


class FlownTask:
    """The task of one sortie, or its flight home.

    Args:
        flight: the flight.
        executive: flies the task.
        mission: says where it begins, and what to do if no plan exists.
        limit: the limit of the flight.

    Attributes:
        failure: why it did not end well; None if it did, or has not ended.
        is_interrupted: whether it is to be continued.
    """

    def __init__(
        self,
        flight: Flight,
        executive: Executive,
        mission: Mission,
        limit: LimitWatch,
    ) -> None:
        self.failure: CompanionError | None = None
        self.is_interrupted = False
        self._flight, self._executive = flight, executive
        self._home, self._otherwise = mission.home.name, mission.otherwise
        self._safe = SafePlaces(flight, executive.planner, mission.safe_places)
        self._limit, self._low_battery = limit, LowBattery(flight, executive.planner)
        self._return_home: ReturnHome | None = None
        self._was_satisfied = False

    @property
    def is_satisfied(self) -> bool:
        """Whether the task is satisfied."""
        return self._was_satisfied or self._executive.status is TaskStatus.SATISFIED

    @property
    def is_called_home(self) -> bool:
        """Whether the flight home is flown."""
        return self._return_home is not None

    @property
    def called_to(self) -> str:
        """Where the flight home leads; "" while the task is flown."""
        return "" if self._return_home is None else self._return_home.place

    @property
    def goes_on(self) -> SortieEvent:
        """The event with which it continues."""
        is_home = self.is_called_home
        return SortieEvent.RETURN_GOES_ON if is_home else SortieEvent.TASK_GOES_ON

    def call_home(self, place: str = "") -> None:
        """From now on flies home, or to another place."""
        if self._return_home is None:
            self._executive.stop()
            self._return_home = ReturnHome(self._flight, place or self._home)

    def resume_ending(self, ending: EndingBegun) -> None:
        """Takes over an end that had begun before the companion was cut off."""
        self._was_satisfied = ending.is_satisfied
        if ending.is_called_home:
            self.call_home(ending.place)

    def interrupt(self) -> None:
        """Interrupts it in the air; later it continues from wherever the vehicle is.

        This also happens if a pilot or a failsafe takes control in a landing or take-off of the
        plan.
        """
        self._safe.forget()
        if self._return_home is None:
            self._executive.pause()
        else:
            self._return_home.stop()
        self._flight.progress.leave_ground()
        self.is_interrupted = True

    def sense(self, readings: Sequence[tuple[Signal, float]], phase: Phase) -> None:
        """Takes readings; the clocks of bounded lines run until the end begins.

        Time passes before the events are taken: an event that comes just as a clock runs out is
        late.
        """
        task, now_s = self._flight.task, self._flight.now_s
        has_begun = phase is Phase.TASK or task.now_s > 0.0
        is_counted = has_begun and phase in CLOCKED and not self.is_called_home
        if is_counted:
            task.now_s = now_s
            tell_late(self._flight)
        self._executive.sense(readings)

    def tick_paused(self) -> SortieEvent | None:
        """One tick of a pause, in which the vehicle holds; how the charge ends it, or None."""
        self._flight.guidance.hold()
        energy = self._executive.planner.energy
        is_needed = energy is not None and energy.is_needed_to_land
        if is_needed or (self.is_called_home and self._low_battery.is_due):
            self._flight.report(PauseEnded())
            return self.goes_on
        return self._call_home_for_battery()

    def tick(self) -> SortieEvent | None:
        """One tick; returns how it ended, or None while it continues."""
        if self._return_home is not None:
            return self._fly_home(self._return_home)
        executive = self._executive
        if event := self._called_home():
            return event
        is_planned = executive.lasso is not None and not executive.is_leaving
        self._flight.guidance.is_for_task = is_planned
        status = executive.resume() if self.is_interrupted else executive.tick()
        self.is_interrupted = False
        if status is TaskStatus.SATISFIED:
            self.failure = executive.failure  # set if this was only the flight to a safe place
            return SortieEvent.SATISFIED
        is_waiting = executive.is_leaving and isinstance(executive.state, AwaitingPlan)
        is_lost = status is TaskStatus.NO_PLAN or is_waiting
        if not is_lost and not executive.is_leaving:
            self._safe.forget()
        event = self._without_plan(is_waiting) if is_lost else None
        needs_take_off = executive.status is TaskStatus.NEEDS_TAKE_OFF
        return SortieEvent.NEEDS_TAKE_OFF if needs_take_off else event

    def _called_home(self) -> SortieEvent | None:
        """Calls the vehicle home because of a limit of the flight or a low battery.

        Not while it flies home anyway, and not while it is on the ground by its plan.
        """
        if self._executive.is_leaving or self._flight.progress.is_landed_by_plan:
            return None
        if limit := self._limit.due(self._executive.laps):
            self._limit.call_home(limit)
            self._flight.report(FlightLimitReached(limit))
            self.call_home()
            return SortieEvent.CALLED_HOME
        return self._call_home_for_battery()

    def _call_home_for_battery(self) -> SortieEvent | None:
        place = self._low_battery.refuge()
        if place is None:
            return None
        self.failure = Aborted(IN_FLIGHT)
        self._flight.report(BatteryLow(place))
        self.call_home(place)
        return SortieEvent.CALLED_HOME

    def _without_plan(self, is_waiting: bool) -> SortieEvent | None:
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
                self.failure = executive.failure
                return SortieEvent.SATISFIED
            case WayToSafePlace(place, lasso):
                executive.leave(lasso)
                flight.report(ReturnBegun(place))
            case NoSafePlace() if not is_waiting:
                self.failure = executive.failure
                is_hold = self._otherwise is Otherwise.HOLD
                return SortieEvent.LEFT_ON_HOLD if is_hold else SortieEvent.OUT_OF_PLANS
            case None:
                flight.guidance.hold()
        return None

    def _fly_home(self, return_home: ReturnHome) -> SortieEvent | None:
        self._flight.guidance.is_for_task = False
        outcome = return_home.tick()
        if outcome is Progress.DONE:
            return SortieEvent.SATISFIED
        if not isinstance(outcome, Failed):
            return None
        failed = ReturnFailed(return_home.place, outcome.reason)
        if self._limit.called_home_for is None:
            self.failure = self.failure or Aborted(failed.text)
        self._flight.report(failed)
        return SortieEvent.NO_WAY_HOME
