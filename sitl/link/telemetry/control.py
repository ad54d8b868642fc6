"""Telemetry of the controllers: setpoints and motor commands.

Source: common.xml; NaN where nothing is controlled.
"""

from __future__ import annotations

import math

from companion.mavlink.framing import Fields
from sitl.link.vehicle import SimulatedVehicle

NAN = math.nan
MOTORS, OUTPUTS = 4, 32


def position_target_local_ned(v: SimulatedVehicle) -> Fields:
    """POSITION_TARGET_LOCAL_NED: the setpoint of the control cascade, NaN where none."""
    setpoint = v.autopilot.control.setpoint
    nothing = (None, None, None)
    position = setpoint.position if setpoint else nothing
    velocity = setpoint.velocity if setpoint else nothing
    return (
        v.boot_ms,
        1,
        0,
        *(_or_nan(x) for x in (*position, *velocity)),
        *(setpoint.acceleration if setpoint else (NAN, NAN, NAN)),
        _or_nan(setpoint.yaw_rad if setpoint else None),
        _or_nan(setpoint.yaw_rate_radps if setpoint else None),
    )


def servo_output_raw(v: SimulatedVehicle) -> Fields:
    """SERVO_OUTPUT_RAW: motor commands as 1000 to 2000 us."""
    pulses = (round(1000 + 1000 * motor) for motor in v.state.motors)
    return (v.boot_us % 2**32, 0, *pulses, *(0,) * 4)


def attitude_target(v: SimulatedVehicle) -> Fields:
    """ATTITUDE_TARGET: the setpoint of the attitude and the share of the full thrust."""
    attitude, thrust = v.autopilot.control.attitude_target
    return (v.boot_ms, 0, attitude, 0.0, 0.0, 0.0, thrust)


def actuator_output_status(v: SimulatedVehicle) -> Fields:
    """ACTUATOR_OUTPUT_STATUS: motor commands, 0 to 1."""
    outputs = (*v.state.motors, *(0.0,) * (OUTPUTS - MOTORS))
    return (v.boot_us, MOTORS, outputs)


def _or_nan(value: float | None) -> float:
    return NAN if value is None else value
