"""The autopilot's parameters and their values.

The table has PX4's names, types and defaults (PX4 1.16, quadrotor in SITL): those that our modes
and failsafes read, and those without which a ground station complains. To add a parameter, add a
row. Values are plain numbers here; companion/mavlink/parameters.py encodes them.

Left out: ranges. PX4 stores a value out of range as it is, and so does this module.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

from companion.mavlink.parameters import INT32, REAL32
from companion.vehicle_profile import VehicleProfile

PARAMETERS: dict[str, tuple[int, float]] = {
    "BAT1_CAPACITY": (REAL32, -1.0),
    "BAT1_N_CELLS": (INT32, 4),
    "BAT1_R_INTERNAL": (REAL32, -1.0),
    "BAT1_SOURCE": (INT32, 0),
    "BAT1_V_CHARGED": (REAL32, 4.05),
    "BAT1_V_EMPTY": (REAL32, 3.6),
    "BAT_AVRG_CURRENT": (REAL32, 15.0),
    "BAT_CRIT_THR": (REAL32, 0.07),
    "BAT_EMERGEN_THR": (REAL32, 0.05),
    "BAT_LOW_THR": (REAL32, 0.15),
    "CAL_ACC0_ID": (INT32, 1310988),
    "CAL_GYRO0_ID": (INT32, 1310988),
    "CAL_MAG0_ID": (INT32, 197388),
    "CAL_MAG0_ROT": (INT32, -1),
    "CBRK_FLIGHTTERM": (INT32, 121212),
    "CBRK_IO_SAFETY": (INT32, 22027),
    "CBRK_SUPPLY_CHK": (INT32, 0),
    "CBRK_USB_CHK": (INT32, 197848),
    "COM_ARM_BAT_MIN": (REAL32, -1.0),
    "COM_ARM_MIS_REQ": (INT32, 0),
    "COM_ARM_WO_GPS": (INT32, 1),
    "COM_DISARM_LAND": (REAL32, 2.0),
    "COM_DISARM_PRFLT": (REAL32, 10.0),
    "COM_DLL_EXCEPT": (INT32, 0),
    "COM_DL_LOSS_T": (INT32, 10),
    "COM_FAIL_ACT_T": (REAL32, 5.0),
    "COM_FLIGHT_UUID": (INT32, 0),
    "COM_FLTMODE1": (INT32, -1),
    "COM_FLTMODE2": (INT32, -1),
    "COM_FLTMODE3": (INT32, -1),
    "COM_FLTMODE4": (INT32, -1),
    "COM_FLTMODE5": (INT32, -1),
    "COM_FLTMODE6": (INT32, -1),
    "COM_FLT_TIME_MAX": (INT32, -1),
    "COM_HOME_EN": (INT32, 1),
    "COM_KILL_DISARM": (REAL32, 5.0),
    "COM_LOW_BAT_ACT": (INT32, 0),
    "COM_OBC_LOSS_T": (REAL32, 5.0),
    "COM_OBL_RC_ACT": (INT32, 0),
    "COM_OF_LOSS_T": (REAL32, 1.0),
    "COM_POSCTL_NAVL": (INT32, 0),
    "COM_POS_FS_EPH": (REAL32, 5.0),
    "COM_PREARM_MODE": (INT32, 0),
    "COM_RCL_EXCEPT": (INT32, 0),
    "COM_RC_IN_MODE": (INT32, 1),
    "COM_RC_LOSS_T": (REAL32, 0.5),
    "COM_RC_OVERRIDE": (INT32, 1),
    "COM_SPOOLUP_TIME": (REAL32, 1.0),
    "COM_TAKEOFF_ACT": (INT32, 0),
    "COM_VEL_FS_EVH": (REAL32, 1.0),
    "COM_WIND_MAX": (REAL32, -1.0),
    "EKF2_REQ_NSATS": (INT32, 6),
    "GF_ACTION": (INT32, 2),
    "GF_MAX_HOR_DIST": (REAL32, 0.0),
    "GF_MAX_VER_DIST": (REAL32, 0.0),
    "GF_PREDICT": (INT32, 0),
    "GF_SOURCE": (INT32, 0),
    "LNDMC_ALT_GND": (REAL32, 2.0),
    "LNDMC_ROT_MAX": (REAL32, 20.0),
    "LNDMC_TRIG_TIME": (REAL32, 1.0),
    "LNDMC_XY_VEL_MAX": (REAL32, 1.5),
    "LNDMC_Z_VEL_MAX": (REAL32, 0.25),
    "LND_FLIGHT_T_HI": (INT32, 0),
    "LND_FLIGHT_T_LO": (INT32, 0),
    "MAV_COMP_ID": (INT32, 1),
    "MAV_FWDEXTSP": (INT32, 1),
    "MAV_HASH_CHK_EN": (INT32, 1),
    "MAV_HB_FORW_EN": (INT32, 1),
    "MAV_PROTO_VER": (INT32, 2),
    "MAV_SYS_ID": (INT32, 1),
    "MAV_TYPE": (INT32, 2),
    "MC_AIRMODE": (INT32, 0),
    "MC_BAT_SCALE_EN": (INT32, 0),
    "MC_PITCH_P": (REAL32, 4.0),
    "MC_ROLL_P": (REAL32, 4.0),
    "MC_YAW_P": (REAL32, 2.8),
    "MIS_COMMAND_TOUT": (REAL32, 0.0),
    "MIS_TAKEOFF_ALT": (REAL32, 2.5),
    "MIS_YAW_ERR": (REAL32, 12.0),
    "MIS_YAW_TMT": (REAL32, -1.0),
    "MPC_ACC_DOWN_MAX": (REAL32, 3.0),
    "MPC_ACC_HOR": (REAL32, 3.0),
    "MPC_ACC_HOR_MAX": (REAL32, 5.0),
    "MPC_ACC_UP_MAX": (REAL32, 4.0),
    "MPC_JERK_AUTO": (REAL32, 4.0),
    "MPC_JERK_MAX": (REAL32, 8.0),
    "MPC_LAND_ALT1": (REAL32, 10.0),
    "MPC_LAND_ALT2": (REAL32, 5.0),
    "MPC_LAND_ALT3": (REAL32, 1.0),
    "MPC_LAND_CRWL": (REAL32, 0.3),
    "MPC_LAND_SPEED": (REAL32, 0.7),
    "MPC_MAN_TILT_MAX": (REAL32, 35.0),
    "MPC_POS_MODE": (INT32, 4),
    "MPC_THR_HOVER": (REAL32, 0.5),
    "MPC_THR_MAX": (REAL32, 1.0),
    "MPC_THR_MIN": (REAL32, 0.12),
    "MPC_TILTMAX_AIR": (REAL32, 45.0),
    "MPC_TILTMAX_LND": (REAL32, 12.0),
    "MPC_TKO_RAMP_T": (REAL32, 3.0),
    "MPC_TKO_SPEED": (REAL32, 1.5),
    "MPC_VEL_MANUAL": (REAL32, 10.0),
    "MPC_XY_CRUISE": (REAL32, 5.0),
    "MPC_XY_P": (REAL32, 0.95),
    "MPC_XY_VEL_ALL": (REAL32, -10.0),
    "MPC_XY_VEL_MAX": (REAL32, 12.0),
    "MPC_YAWRAUTO_MAX": (REAL32, 60.0),
    "MPC_YAW_MODE": (INT32, 0),
    "MPC_Z_P": (REAL32, 1.0),
    "MPC_Z_VEL_ALL": (REAL32, -3.0),
    "MPC_Z_VEL_MAX_DN": (REAL32, 1.5),
    "MPC_Z_VEL_MAX_UP": (REAL32, 3.0),
    "MPC_Z_V_AUTO_DN": (REAL32, 1.5),
    "MPC_Z_V_AUTO_UP": (REAL32, 3.0),
    "NAV_ACC_RAD": (REAL32, 2.0),
    "NAV_DLL_ACT": (INT32, 0),
    "NAV_LOITER_RAD": (REAL32, 80.0),
    "NAV_MC_ALT_RAD": (REAL32, 0.8),
    "NAV_RCL_ACT": (INT32, 2),
    "RC_CHAN_CNT": (INT32, 0),
    "RC_MAP_ARM_SW": (INT32, 0),
    "RC_MAP_FLTMODE": (INT32, 0),
    "RC_MAP_KILL_SW": (INT32, 0),
    "RC_MAP_PITCH": (INT32, 0),
    "RC_MAP_ROLL": (INT32, 0),
    "RC_MAP_THROTTLE": (INT32, 0),
    "RC_MAP_YAW": (INT32, 0),
    "RTL_CONE_ANG": (INT32, 45),
    "RTL_DESCEND_ALT": (REAL32, 10.0),
    "RTL_LAND_DELAY": (REAL32, 0.0),
    "RTL_MIN_DIST": (REAL32, 10.0),
    "RTL_RETURN_ALT": (REAL32, 30.0),
    "RTL_TYPE": (INT32, 0),
    "SENS_BOARD_ROT": (INT32, 0),
    "SYS_AUTOCONFIG": (INT32, 0),
    "SYS_AUTOSTART": (INT32, 10040),
    "SYS_HAS_BARO": (INT32, 1),
    "SYS_HAS_GPS": (INT32, 1),
    "SYS_HAS_MAG": (INT32, 1),
    "SYS_HITL": (INT32, 0),
    "THR_MDL_FAC": (REAL32, 0.0),
}
"""Name -> type and PX4's default, in PX4's alphabetical order, which defines the index."""

AIRFRAME_DEFAULTS: dict[str, float] = {
    "COM_OBL_RC_ACT": 5,  # hold when the offboard stream is lost; PX4's 0 sinks without a pilot
    "COM_LOW_BAT_ACT": 3,  # return at critical, land at emergency; PX4's 0 only warns
}
"""This airframe's own defaults, like `param set-default` in a PX4 airframe file."""


def vehicle_defaults(vehicle: VehicleProfile) -> dict[str, float]:
    """The defaults that a vehicle profile sets for limits of the controllers."""
    return {
        "MPC_XY_VEL_MAX": vehicle.speed_mps,
        "MPC_Z_VEL_MAX_UP": vehicle.climb_mps,
        "MPC_Z_VEL_MAX_DN": vehicle.descent_mps,
        "MPC_ACC_HOR_MAX": vehicle.max_acceleration_mps2,
        "MPC_JERK_MAX": vehicle.jerk_mps3,
    }


_NAMES = list(PARAMETERS)


class Parameters:
    """The present value of each parameter.

    Args:
        overrides: values that differ from the airframe's defaults; every name must be known.
    """

    def __init__(self, overrides: Mapping[str, float] | None = None) -> None:
        self._values = {name: default for name, (_, default) in PARAMETERS.items()}
        self._values |= AIRFRAME_DEFAULTS
        for name, value in (overrides or {}).items():
            self.set(name, value)

    def __getitem__(self, name: str) -> float:
        return self._values[name]

    def set(self, name: str, value: float) -> None:
        """Stores a value; a float that is not finite changes nothing.

        Raises:
            KeyError: an unknown name.
        """
        param_type, _ = PARAMETERS[name]
        if math.isfinite(value):
            self._values[name] = int(value) if param_type == INT32 else float(value)


def index_of(name: str) -> int:
    """The index of a known parameter."""
    return _NAMES.index(name)
