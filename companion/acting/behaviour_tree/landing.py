"""The leaves that leave the air: landing, charging, taking off again.

While the vehicle is on the ground by its own plan (`PlanProgress.is_landed_by_plan`), nothing
interrupts the plan, and being disarmed is no loss of control. goals_in_order.py has the ways down
and up. If the plan fails on the ground, the vehicle takes off again before the next plan begins
(`sortie.py`).
"""

from __future__ import annotations

from py_trees.common import Status

from companion.acting.behaviour_tree.leaf import Leaf
from companion.acting.flight import Flight
from companion.acting.goals_in_order import WayDown, WayUp
from companion.acting.landing_wait import LandingWait
from companion.flight_events.sortie import (
    BatteryCharged,
    ChargeAwaited,
    ChargeCutShort,
    ChargeSufficient,
    VehicleLanded,
)
from companion.flight_events.tree import LeafType
from companion.outcomes import Progress

NO_CHARGE_S = 120.0
"""Time without one more percent after which a charger is given up."""
SLOW_WINDOWS = 2
"""How many consecutive windows with too little charge are allowed; a power cut is no slow dock."""


class LandVehicle(Leaf):
    """Lands where the vehicle is, and disarms."""

    does = LeafType.LAND

    def initialise(self) -> None:
        """Lets the vehicle come to rest first."""
        self._wait = LandingWait(self._flight)
        self._way = WayDown(self._flight)

    def update(self) -> Status:
        """SUCCESS on the ground."""
        if self._wait.tick() is Progress.RUNNING:
            return Status.RUNNING
        outcome = self._way.tick()
        if outcome is Progress.DONE:
            self._flight.report(VehicleLanded())
        return self.status_of(outcome)


class TakeOffVehicle(Leaf):
    """Arms, climbs to the altitude of its place, and takes control in OFFBOARD."""

    does = LeafType.TAKE_OFF

    def initialise(self) -> None:
        """Begins with arming."""
        self._way = WayUp(self._flight)

    def update(self) -> Status:
        """SUCCESS in the air."""
        return self.status_of(self._way.tick())


class BeginAgain(Leaf):
    """Before each try of a skill that lands or takes off, restores where the first try began.

    If the first try began in the air, the vehicle takes off again, if its charge lasts for that. It
    does not land unless told to: a skill that began on the ground and has taken off is not tried
    again.
    """

    does = LeafType.BEGIN_AGAIN

    def __init__(self, flight: Flight) -> None:
        super().__init__(flight, "as at first?")
        self._first_at: int | None = None
        self._began_on_ground, self._lasts = False, True
        self._way: WayUp | None = None

    def initialise(self) -> None:
        """Notes where the first try of an action begins; no position is left between its tries."""
        progress, positions = self._flight.progress, self._flight.task.word.positions
        if self._first_at != positions:
            self._first_at = positions
            self._began_on_ground = progress.is_landed_by_plan
        self._lasts = True
        if progress.is_landed_by_plan and not self._began_on_ground:
            self._lasts = self._flight.dock.lasts_for_another_try
            self._way = WayUp(self._flight)

    def update(self) -> Status:
        """SUCCESS once the vehicle is where the first try began: in the air, or on the ground."""
        if self._flight.progress.is_landed_by_plan == self._began_on_ground:
            return Status.SUCCESS
        if self._began_on_ground:
            return self.fail("not tried again: it began on the ground, and is in the air")
        if not self._lasts:
            return self.fail("not tried again: the charge does not last for it, the reserve left")
        assert self._way is not None
        return self.status_of(self._way.tick())


class ChargeBattery(Leaf):
    """Waits until the battery has reached a level.

    A dock is given up if it gives no percent in two minutes, or twice in a row, in two minutes,
    less than half of what the mission says. If the vehicle cannot go to another dock, it waits
    longer. The event of a ready line ends the charge, once there is enough charge for the answer.
    """

    does = LeafType.CHARGE

    def __init__(self, flight: Flight, percent: float, called_percent: int | None = None) -> None:
        super().__init__(flight, f"charge {percent:g} %")
        self._percent, self._called_percent = percent, called_percent

    def initialise(self) -> None:
        """Starts to measure."""
        self._most = -1
        self._since_s = self._flight.now_s
        self._window: tuple[float, int] | None = None  # its beginning, and the percents then
        self._slow_windows = 0
        self._is_told = False

    def update(self) -> Status:
        """SUCCESS at the percentage; FAILURE if the charge no longer rises, or rises too slowly."""
        flight, state = self._flight, self._flight.vehicle.state
        percent = state.battery.percent if state else None
        if percent is not None and percent >= self._percent:
            flight.report(BatteryCharged(percent))
            return Status.SUCCESS
        if percent is not None and self._is_called(percent):
            flight.report(ChargeCutShort(percent))
            return Status.SUCCESS
        if percent is not None and percent > self._most:
            self._most, self._since_s = percent, flight.now_s
        if flight.now_s - self._since_s > NO_CHARGE_S:
            return self._await_power(percent)
        if percent is not None:
            self._measure(percent)
        if self._slow_windows >= SLOW_WINDOWS and not flight.dock.patience_s:
            return self.fail(f"the battery charges too slowly, it is at {percent} %")
        return Status.RUNNING

    def _is_called(self, percent: int) -> bool:
        """Whether an event asks for an answer for which there is enough charge."""
        enough = self._called_percent
        return enough is not None and percent >= enough and self._flight.task.word.is_called

    def _await_power(self, percent: int | None) -> Status:
        """At a dock that gives nothing: FAILURE if another dock is to be used, or finally."""
        flight, patience_s = self._flight, self._flight.dock.patience_s
        if flight.now_s - self._since_s > NO_CHARGE_S + patience_s:
            known = "unknown" if percent is None else f"{percent} %"
            return self.fail(f"the battery does not charge, it is at {known}")
        if percent is not None and not self._is_told:
            self._is_told = True
            flight.report(ChargeAwaited(percent, round(patience_s)))
        self._window, self._slow_windows = None, 0  # measures again from when it gives again
        return Status.RUNNING

    def _measure(self, percent: int) -> None:
        """Compares the charge of two minutes with what the mission says, then starts again."""
        now_s = self._flight.now_s
        begun_s, before = self._window or (now_s, percent)
        if now_s - begun_s > NO_CHARGE_S:
            expected_s = self._flight.dock.charging_s(before, percent + 1)
            is_slow = expected_s < (now_s - begun_s) / 2
            self._slow_windows = self._slow_windows + 1 if is_slow else 0
            begun_s, before = now_s, percent
        self._window = begun_s, before


class EnoughCharge(Leaf):
    """Checks that the battery has so much charge that the vehicle need not land."""

    does = LeafType.CHARGE

    def __init__(self, flight: Flight, percent: int) -> None:
        super().__init__(flight, f"{percent} % already?")
        self._percent = percent

    def update(self) -> Status:
        """SUCCESS in the air with enough charge."""
        flight, state = self._flight, self._flight.vehicle.state
        percent = state.battery.percent if state else None
        if flight.progress.is_landed_by_plan or percent is None:
            return self.fail("the battery has less")
        percent = min(percent, flight.believed_percent)
        if percent < self._percent:
            return self.fail("the battery has less")
        flight.report(ChargeSufficient(percent, self._percent))
        return Status.SUCCESS
