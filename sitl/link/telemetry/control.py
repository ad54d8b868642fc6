"""What do the controllers want, and what do the motors get?

Source: common.xml; NaN where nothing is controlled.
"""

from __future__ import annotations

import math

from companion.mavlink.framing import Fields
from sitl.link.vehicle import Vehicle

NAN = math.nan
MOTORS, OUTPUTS = 4, 32


def position_target_local_ned(v: Vehicle) -> Fields:
    """POSITION_TARGET_LOCAL_NED: what the control cascade follows, NaN where nothing."""
    target = v.autopilot.control.target
    nothing = (None, None, None)
    position = target.position if target else nothing
    velocity = target.velocity if target else nothing
    return (
        v.boot_ms,
        1,
        0,
        *(_or_nan(x) for x in (*position, *velocity)),
        *(target.acceleration if target else (NAN, NAN, NAN)),
        _or_nan(target.yaw_rad if target else None),
        _or_nan(target.yaw_rate_radps if target else None),
    )


def servo_output_raw(v: Vehicle) -> Fields:
    """SERVO_OUTPUT_RAW: motor commands as 1000 to 2000 us."""
    pulses = (round(1000 + 1000 * motor) for motor in v.autopilot.control.motors)
    return (v.boot_us % 2**32, 0, *pulses, *(0,) * 4)


def attitude_target(v: Vehicle) -> Fields:
    """ATTITUDE_TARGET: the attitude and the share of the full thrust that are wanted."""
    attitude, thrust = v.autopilot.control.attitude_target
    return (v.boot_ms, 0, attitude, 0.0, 0.0, 0.0, thrust)


def actuator_output_status(v: Vehicle) -> Fields:
    """ACTUATOR_OUTPUT_STATUS: motor commands, 0 to 1."""
    outputs = (*v.autopilot.control.motors, *(0.0,) * (OUTPUTS - MOTORS))
    return (v.boot_us, MOTORS, outputs)


def _or_nan(value: float | None) -> float:
    return NAN if value is None else value
