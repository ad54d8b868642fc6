"""The failsafes: when each demands an action, and which one.

Each failsafe is a pure function of the `FailsafeInputs`; `FAILSAFES` is their table. Which one
wins, when it acts and when it ends is in failsafe_state.py. To add a failsafe, add a row.

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


class FailsafeAction(IntEnum):
    """The actions of failsafes, the most severe last."""

    WARN = 1
    POSITION = 2
    ALTITUDE = 3
    HOLD = 4
    RETURN = 5
    LAND = 6
    DESCEND = 7
    DISARM = 8
    TERMINATE = 9


class FailsafeCause(StrEnum):
    """The causes of failsafes; the value is the text for people."""

    OFFBOARD_LOST = "no offboard signal"
    GROUND_STATION_LOST = "connection to ground control lost"
    BATTERY = "battery"
    GEOFENCE = "geofence violated"
    POSITION_LOST = "no valid position"


class FailsafeInputs(NamedTuple):
    """The inputs of the failsafes.

    Attributes:
        intended_mode: the mode that was commanded.
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
        """Whether the position estimate cannot be trusted."""
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


def _termination(parameters: Parameters) -> FailsafeAction:
    """Flight termination, or a landing while its circuit breaker is set."""
    is_broken = parameters["CBRK_FLIGHTTERM"] == TERMINATION_BREAKER
    return FailsafeAction.LAND if is_broken else FailsafeAction.TERMINATE


def _chosen(
    parameters: Parameters, name: str, actions: Mapping[int, FailsafeAction]
) -> FailsafeAction | None:
    action = actions.get(int(parameters[name]))
    return _termination(parameters) if action is FailsafeAction.TERMINATE else action


_OFFBOARD_LOSS = {
    0: FailsafeAction.POSITION,
    1: FailsafeAction.ALTITUDE,
    2: FailsafeAction.ALTITUDE,  # MANUAL: without a pilot the same as ALTCTL
    3: FailsafeAction.RETURN,
    4: FailsafeAction.LAND,
    5: FailsafeAction.HOLD,
    6: FailsafeAction.TERMINATE,
    7: FailsafeAction.DISARM,
}
"""By COM_OBL_RC_ACT; PX4 would first ask a remote control, which does not exist here."""

_LINK_LOSS = {
    1: FailsafeAction.HOLD,
    2: FailsafeAction.RETURN,
    3: FailsafeAction.LAND,
    5: FailsafeAction.TERMINATE,
    6: FailsafeAction.DISARM,
}
"""By NAV_DLL_ACT; 0 is off."""

_BREACH = {
    1: FailsafeAction.WARN,
    2: FailsafeAction.HOLD,
    3: FailsafeAction.RETURN,
    4: FailsafeAction.TERMINATE,
    5: FailsafeAction.LAND,
}
"""By GF_ACTION; 0 is off."""

_BATTERY = {
    (2, BatteryLevel.CRITICAL): FailsafeAction.LAND,
    (2, BatteryLevel.EMERGENCY): FailsafeAction.LAND,
    (3, BatteryLevel.CRITICAL): FailsafeAction.RETURN,
    (3, BatteryLevel.EMERGENCY): FailsafeAction.LAND,
}
"""By COM_LOW_BAT_ACT and level; 0 only warns."""

_EXCEPTIONS = {"AUTO.MISSION": 1, "AUTO.LOITER": 2, "OFFBOARD": 4}
"""Bits of COM_DLL_EXCEPT: modes that need no ground station."""

_NEEDS_NO_POSITION = frozenset({"ALTCTL", "MANUAL", "STABILIZED", "ACRO"})


def _offboard_loss(now: FailsafeInputs) -> FailsafeAction | None:
    limit_s = now.parameters["COM_OF_LOSS_T"] + LOSS_NOTICED_S
    if now.intended_mode != "OFFBOARD" or now.setpoint_age_s <= limit_s:
        return None
    return _chosen(now.parameters, "COM_OBL_RC_ACT", _OFFBOARD_LOSS) or FailsafeAction.LAND


def _ground_station_loss(now: FailsafeInputs) -> FailsafeAction | None:
    limit_s = now.parameters["COM_DL_LOSS_T"] + LINK_SILENT_S
    excepted = int(now.parameters["COM_DLL_EXCEPT"]) & _EXCEPTIONS.get(now.intended_mode, 0)
    if now.ground_station_age_s <= limit_s or excepted:
        return None
    return _chosen(now.parameters, "NAV_DLL_ACT", _LINK_LOSS)


def _battery(now: FailsafeInputs) -> FailsafeAction | None:
    return _BATTERY.get((int(now.parameters["COM_LOW_BAT_ACT"]), now.battery))


def _breach(now: FailsafeInputs) -> FailsafeAction | None:
    if not now.is_fence_breached:
        return None
    return _chosen(now.parameters, "GF_ACTION", _BREACH)


def _position_loss(now: FailsafeInputs) -> FailsafeAction | None:
    if not now.is_position_lost or now.intended_mode in _NEEDS_NO_POSITION:
        return None
    is_auto = now.intended_mode.startswith("AUTO.")
    return (
        FailsafeAction.DESCEND
        if is_auto or now.parameters["COM_POSCTL_NAVL"] == 1
        else FailsafeAction.ALTITUDE
    )


@dataclass(frozen=True, slots=True)
class Failsafe:
    """A row of `FAILSAFES`.

    Attributes:
        action: the action that the inputs demand; None for no action.
        allows_delay: whether an action worse than holding waits for COM_FAIL_ACT_T.
        is_latched: it acts until the mode is changed, even if its condition ends.
    """

    cause: FailsafeCause
    action: Callable[[FailsafeInputs], FailsafeAction | None]
    allows_delay: bool
    is_latched: bool


FAILSAFES = (
    Failsafe(FailsafeCause.BATTERY, _battery, allows_delay=True, is_latched=True),
    Failsafe(FailsafeCause.GEOFENCE, _breach, allows_delay=True, is_latched=True),
    Failsafe(
        FailsafeCause.GROUND_STATION_LOST, _ground_station_loss, allows_delay=True, is_latched=False
    ),
    Failsafe(FailsafeCause.POSITION_LOST, _position_loss, allows_delay=False, is_latched=False),
    Failsafe(FailsafeCause.OFFBOARD_LOST, _offboard_loss, allows_delay=False, is_latched=False),
)
"""Among equal actions, the first one is reported."""
