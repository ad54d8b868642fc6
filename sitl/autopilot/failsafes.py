"""Which failsafes does the autopilot's situation call for, and what shall they do?

A pure function of the `Conditions` for each failsafe, and a table of them; which one wins, when it
acts and when it ends is in failsafe_state.py. A new failsafe is a new line in `FAILSAFES`.

Source: PX4 1.16, src/modules/commander/failsafe, and user guide, "Safety Configuration"; timings
measured. Left out: failsafes of a remote control (there is none), of wind, flight time, motors and
sensors other than GPS.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from enum import IntEnum, StrEnum
from typing import NamedTuple

from sitl.autopilot.parameters import Parameters

LOSS_NOTICED_S = 0.03  # PX4 was seen to change the mode 9 to 94 ms after COM_OF_LOSS_T
LINK_SILENT_S = 2.5  # PX4 calls a ground station lost this long after its last heartbeat
POSITION_LOST_S = 5.0  # EKF2_NOAID_TOUT: dead reckoning is trusted this long
TERMINATION_BREAKER = 121212  # CBRK_FLIGHTTERM: the motors are not stopped in the air


class BatteryLevel(IntEnum):
    """Warning level of the battery; the values are MAV_BATTERY_CHARGE_STATE."""

    OK = 1
    LOW = 2
    CRITICAL = 3
    EMERGENCY = 4


class Action(IntEnum):
    """What a failsafe does, the most severe last."""

    WARN = 1
    POSITION = 2
    ALTITUDE = 3
    HOLD = 4
    RETURN = 5
    LAND = 6
    DESCEND = 7
    DISARM = 8
    TERMINATE = 9


class Cause(StrEnum):
    """Why a failsafe acts; the value is how people are told."""

    OFFBOARD_LOST = "no offboard signal"
    GROUND_STATION_LOST = "connection to ground control lost"
    BATTERY = "battery"
    GEOFENCE = "geofence violated"
    POSITION_LOST = "no valid position"


class Conditions(NamedTuple):
    """What the failsafes look at.

    Attributes:
        intended_mode: the mode that was asked for.
        setpoint_age_s: time since the last valid offboard setpoint, inf before the first.
        ground_station_age_s: time since the last heartbeat of a ground station.
        position_age_s: time since the position was last measured.
        is_fence_breached: the vehicle is outside the geofence.
    """

    intended_mode: str
    setpoint_age_s: float
    battery: BatteryLevel
    parameters: Parameters
    ground_station_age_s: float = 0.0
    position_age_s: float = 0.0
    is_fence_breached: bool = False

    @property
    def is_position_lost(self) -> bool:
        """The estimate of the position is not to be trusted."""
        return self.position_age_s > POSITION_LOST_S


_THRESHOLDS = (
    ("BAT_EMERGEN_THR", BatteryLevel.EMERGENCY),
    ("BAT_CRIT_THR", BatteryLevel.CRITICAL),
    ("BAT_LOW_THR", BatteryLevel.LOW),
)


def battery_level(charge: float, parameters: Parameters) -> BatteryLevel:
    """The warning level of a state of charge (0 to 1)."""
    for name, level in _THRESHOLDS:
        if charge < parameters[name]:
            return level
    return BatteryLevel.OK


def _termination(parameters: Parameters) -> Action:
    """Flight termination, or a landing while its circuit breaker is set."""
    is_broken = parameters["CBRK_FLIGHTTERM"] == TERMINATION_BREAKER
    return Action.LAND if is_broken else Action.TERMINATE


def _chosen(parameters: Parameters, name: str, actions: Mapping[int, Action]) -> Action | None:
    action = actions.get(int(parameters[name]))
    return _termination(parameters) if action is Action.TERMINATE else action


_OFFBOARD_LOSS = {
    0: Action.POSITION,
    1: Action.ALTITUDE,
    2: Action.ALTITUDE,  # MANUAL: without a pilot no other than ALTCTL
    3: Action.RETURN,
    4: Action.LAND,
    5: Action.HOLD,
    6: Action.TERMINATE,
    7: Action.DISARM,
}
"""COM_OBL_RC_ACT; a remote control, which would be asked first, does not exist here."""

_LINK_LOSS = {
    1: Action.HOLD,
    2: Action.RETURN,
    3: Action.LAND,
    5: Action.TERMINATE,
    6: Action.DISARM,
}
"""NAV_DLL_ACT; 0 is off."""

_BREACH = {
    1: Action.WARN,
    2: Action.HOLD,
    3: Action.RETURN,
    4: Action.TERMINATE,
    5: Action.LAND,
}
"""GF_ACTION; 0 is off."""

_BATTERY = {
    (2, BatteryLevel.CRITICAL): Action.LAND,
    (2, BatteryLevel.EMERGENCY): Action.LAND,
    (3, BatteryLevel.CRITICAL): Action.RETURN,
    (3, BatteryLevel.EMERGENCY): Action.LAND,
}
"""COM_LOW_BAT_ACT and level; 0 only warns."""

_EXCEPTIONS = {"AUTO.MISSION": 1, "AUTO.LOITER": 2, "OFFBOARD": 4}
"""Bits of COM_DLL_EXCEPT: modes that need no ground station."""

_NEEDS_NO_POSITION = frozenset({"ALTCTL", "MANUAL", "STABILIZED", "ACRO"})


def _offboard_loss(now: Conditions) -> Action | None:
    limit_s = now.parameters["COM_OF_LOSS_T"] + LOSS_NOTICED_S
    if now.intended_mode != "OFFBOARD" or now.setpoint_age_s <= limit_s:
        return None
    return _chosen(now.parameters, "COM_OBL_RC_ACT", _OFFBOARD_LOSS) or Action.LAND


def _ground_station_loss(now: Conditions) -> Action | None:
    limit_s = now.parameters["COM_DL_LOSS_T"] + LINK_SILENT_S
    excepted = int(now.parameters["COM_DLL_EXCEPT"]) & _EXCEPTIONS.get(now.intended_mode, 0)
    if now.ground_station_age_s <= limit_s or excepted:
        return None
    return _chosen(now.parameters, "NAV_DLL_ACT", _LINK_LOSS)


def _battery(now: Conditions) -> Action | None:
    return _BATTERY.get((int(now.parameters["COM_LOW_BAT_ACT"]), now.battery))


def _breach(now: Conditions) -> Action | None:
    if not now.is_fence_breached:
        return None
    return _chosen(now.parameters, "GF_ACTION", _BREACH)


def _position_loss(now: Conditions) -> Action | None:
    if not now.is_position_lost or now.intended_mode in _NEEDS_NO_POSITION:
        return None
    is_auto = now.intended_mode.startswith("AUTO.")
    return Action.DESCEND if is_auto or now.parameters["COM_POSCTL_NAVL"] == 1 else Action.ALTITUDE


@dataclass(frozen=True, slots=True)
class Failsafe:
    """A line of `FAILSAFES`.

    Attributes:
        action: what the conditions call for, None for nothing.
        waits: an action worse than holding comes after COM_FAIL_ACT_T.
        is_kept: acts until the mode is changed, even if its condition ends.
    """

    cause: Cause
    action: Callable[[Conditions], Action | None]
    waits: bool
    is_kept: bool


FAILSAFES = (
    Failsafe(Cause.BATTERY, _battery, waits=True, is_kept=True),
    Failsafe(Cause.GEOFENCE, _breach, waits=True, is_kept=True),
    Failsafe(Cause.GROUND_STATION_LOST, _ground_station_loss, waits=True, is_kept=False),
    Failsafe(Cause.POSITION_LOST, _position_loss, waits=False, is_kept=False),
    Failsafe(Cause.OFFBOARD_LOST, _offboard_loss, waits=False, is_kept=False),
)
"""Of equal actions the first is told."""
