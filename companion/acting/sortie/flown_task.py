"""What is flown in OFFBOARD, the task or the flight home; it can be interrupted and continued.

The executive flies the task, and also the flight to a safe place if the task has no plan. The
vehicle is called home for good by the operator, by a limit of the flight, or by a low battery about
which the mission says nothing. From then on only the flight home is flown, whatever safe places
there are.
"""

from __future__ import annotations

from companion.acting.executive import Executive
from companion.acting.executive_states import TaskStatus
from companion.acting.flight import Flight
from companion.acting.journal import EndingBegun
from companion.acting.positions import tell_late
from companion.acting.sortie.low_battery import IN_FLIGHT, LowBattery
from companion.acting.sortie.phase_work import PhaseEnd
from companion.acting.sortie.phases import GOES_ON_WITH, SortieEvent
from companion.acting.sortie.return_home import ReturnHome
from companion.errors import Aborted
from companion.flight_events.sortie import BatteryLow, Phase
from companion.mission.model import Mission

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
        mission: says where it begins.

    Attributes:
        is_interrupted: whether it is to be continued.
        goes_on: the event with which it continues in OFFBOARD.
        flight_home: the flight home; None while the task is flown.
    """

    def __init__(self, flight: Flight, executive: Executive, mission: Mission) -> None:
        self.is_interrupted = False
        self.goes_on = SortieEvent.TASK_GOES_ON
        self.flight_home: ReturnHome | None = None
        self._flight, self._executive = flight, executive
        self._home = mission.home.name
        self._low_battery = LowBattery(flight, executive.planner)
        self._was_satisfied = False

    @property
    def is_satisfied(self) -> bool:
        """Whether the task is satisfied."""
        return self._was_satisfied or self._executive.status is TaskStatus.SATISFIED

    @property
    def is_called_home(self) -> bool:
        """Whether the flight home is flown."""
        return self.flight_home is not None

    @property
    def called_to(self) -> str:
        """Where the flight home leads; "" while the task is flown."""
        return "" if self.flight_home is None else self.flight_home.place

    @property
    def is_battery_low(self) -> bool:
        """Whether the vehicle has to leave the task because of the battery."""
        return self._low_battery.is_due

    def fly(self) -> TaskStatus:
        """One tick of the task; continues it if it was interrupted."""
        is_interrupted, self.is_interrupted = self.is_interrupted, False
        return self._executive.resume() if is_interrupted else self._executive.tick()

    def call_home(self, place: str = "") -> None:
        """From now on flies home, or to another place."""
        if self.flight_home is None:
            self._executive.stop()
            self.flight_home = ReturnHome(self._flight, place or self._home)

    def call_home_for_battery(self) -> PhaseEnd | None:
        """Calls the vehicle away because of a low battery; None if it need not be."""
        place = self._low_battery.refuge()
        if place is None:
            return None
        self._flight.report(BatteryLow(place))
        self.call_home(place)
        return PhaseEnd(SortieEvent.CALLED_HOME, Aborted(IN_FLIGHT))

    def continue_with(self, goes_on: SortieEvent, ending: EndingBegun | None) -> None:
        """Takes over what was flown, and perhaps ending, before the companion was cut off."""
        self.is_interrupted, self.goes_on = True, goes_on
        if ending is not None:
            self._was_satisfied = ending.is_satisfied
            if ending.is_called_home:
                self.call_home(ending.place)
        if goes_on is SortieEvent.RETURN_GOES_ON:
            self.call_home()

    def interrupt(self, phase: Phase) -> None:
        """Interrupts it in the air; later it continues from wherever the vehicle is.

        This also happens if a pilot or a failsafe takes control in a landing or take-off of the
        plan.

        Args:
            phase: in which it is flown or paused.
        """
        if self.flight_home is None:
            self._executive.pause()
        else:
            self.flight_home.stop()
        self._flight.progress.leave_ground()
        self.is_interrupted, self.goes_on = True, GOES_ON_WITH[phase]

    def end_pause(self) -> SortieEvent:
        """Continues with what was paused; returns the event."""
        is_home = self.is_called_home
        self.goes_on = SortieEvent.RETURN_GOES_ON if is_home else SortieEvent.TASK_GOES_ON
        return self.goes_on

    def end(self) -> None:
        """Ends it for good; the vehicle holds."""
        self._executive.stop()

    def pass_time(self, phase: Phase) -> None:
        """Lets the clocks of bounded lines run, until the end of the sortie begins."""
        task, now_s = self._flight.task, self._flight.now_s
        has_begun = phase is Phase.TASK or task.word.now_s > 0.0
        is_counted = has_begun and phase in CLOCKED and not self.is_called_home
        if is_counted:
            task.word.now_s = now_s
            tell_late(self._flight)
