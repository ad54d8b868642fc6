"""Which failsafe does the autopilot's situation call for, and which mode does it fly?

PX4's rules, as a real PX4 was seen to follow them:

1. A failsafe never changes the mode that was asked for; it flies another one while it lasts. So
   PX4 returns to OFFBOARD by itself when the stream of setpoints comes back.
2. Setpoint loss acts at once (COM_OBL_RC_ACT). It is noticed a little after COM_OF_LOSS_T.
3. A low battery warns. Critical and emergency act by COM_LOW_BAT_ACT, after holding for
   COM_FAIL_ACT_T; a rise from critical to emergency does not start that time again.
4. Asking for another mode during a failsafe takes the vehicle over; a further failsafe acts again.

A new failsafe is a new line in `FAILSAFES`. Source: PX4 user guide, "Safety Configuration";
timings measured on PX4 1.16. Left out: loss of the ground station, geofence, wind.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum, IntEnum

from sitl.autopilot.parameters import Parameters

LOSS_NOTICED_S = 0.03  # PX4 was seen to change the mode 9 to 94 ms after COM_OF_LOSS_T


class BatteryLevel(IntEnum):
    """Warning level of the battery; the values are MAV_BATTERY_CHARGE_STATE."""

    OK = 1
    LOW = 2
    CRITICAL = 3
    EMERGENCY = 4


class Cause(Enum):
    """Why a failsafe acts; the value is how people are told."""

    OFFBOARD_LOST = "no offboard signal"
    BATTERY_CRITICAL = "critical battery"
    BATTERY_EMERGENCY = "emergency battery level"


@dataclass(frozen=True, slots=True)
class Conditions:
    """What the failsafes look at.

    Attributes:
        intended_mode: the mode that was asked for.
        setpoint_age_s: time since the last valid offboard setpoint, inf before the first.
    """

    intended_mode: str
    setpoint_age_s: float
    battery: BatteryLevel
    parameters: Parameters


@dataclass(frozen=True, slots=True)
class Failsafe:
    """A mode to fly instead of the intended one; `holds_first` for COM_FAIL_ACT_T."""

    cause: Cause
    mode: str
    holds_first: bool


_OFFBOARD_LOSS_MODES = {0: "POSCTL", 3: "AUTO.RTL", 4: "AUTO.LAND", 5: "AUTO.LOITER"}
"""COM_OBL_RC_ACT -> mode. The others need a pilot or drop the vehicle: landing stands for them."""

_BATTERY_MODES = {
    (2, BatteryLevel.CRITICAL): "AUTO.LAND",
    (2, BatteryLevel.EMERGENCY): "AUTO.LAND",
    (3, BatteryLevel.CRITICAL): "AUTO.RTL",
    (3, BatteryLevel.EMERGENCY): "AUTO.LAND",
}
"""COM_LOW_BAT_ACT and level -> mode; 0 only warns."""

_BATTERY_CAUSES = {
    BatteryLevel.CRITICAL: Cause.BATTERY_CRITICAL,
    BatteryLevel.EMERGENCY: Cause.BATTERY_EMERGENCY,
}


def battery_level(charge: float, parameters: Parameters) -> BatteryLevel:
    """The warning level of a state of charge (0 to 1)."""
    thresholds = (
        ("BAT_EMERGEN_THR", BatteryLevel.EMERGENCY),
        ("BAT_CRIT_THR", BatteryLevel.CRITICAL),
        ("BAT_LOW_THR", BatteryLevel.LOW),
    )
    return next((level for name, level in thresholds if charge < parameters[name]), BatteryLevel.OK)


def _battery(now: Conditions) -> Failsafe | None:
    mode = _BATTERY_MODES.get((int(now.parameters["COM_LOW_BAT_ACT"]), now.battery))
    return Failsafe(_BATTERY_CAUSES[now.battery], mode, holds_first=True) if mode else None


def _offboard_loss(now: Conditions) -> Failsafe | None:
    limit_s = now.parameters["COM_OF_LOSS_T"] + LOSS_NOTICED_S
    if now.intended_mode != "OFFBOARD" or now.setpoint_age_s <= limit_s:
        return None
    mode = _OFFBOARD_LOSS_MODES.get(int(now.parameters["COM_OBL_RC_ACT"]), "AUTO.LAND")
    return Failsafe(Cause.OFFBOARD_LOST, mode, holds_first=False)


FAILSAFES: tuple[Callable[[Conditions], Failsafe | None], ...] = (_battery, _offboard_loss)
"""The most severe first; the first that applies acts."""


class FailsafeState:
    """The failsafe that acts now; one flight of one vehicle.

    Attributes:
        active: None while the intended mode is flown.
    """

    def __init__(self) -> None:
        self.active: Failsafe | None = None
        self._holding_since_s: float | None = None
        self._taken_over: set[Cause] = set()

    def update(self, conditions: Conditions, now_s: float) -> None:
        """Look at the conditions again."""
        demanded = (failsafe(conditions) for failsafe in FAILSAFES)
        self.active = next((f for f in demanded if f and f.cause not in self._taken_over), None)
        if self.active is None or not self.active.holds_first:
            self._holding_since_s = None
        elif self._holding_since_s is None:
            self._holding_since_s = now_s

    def mode(self, now_s: float, hold_s: float) -> str | None:
        """The mode to fly instead of the intended one, None if that one is flown."""
        if self.active is None:
            return None
        since = self._holding_since_s
        return "AUTO.LOITER" if since is not None and now_s - since < hold_s else self.active.mode

    def take_over(self) -> None:
        """The pilot asked for a mode: what acts now shall not act again in this flight."""
        if self.active and self.active.cause is not Cause.OFFBOARD_LOST:
            self._taken_over.add(self.active.cause)
