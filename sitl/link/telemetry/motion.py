"""Telemetry of position and motion, as estimated.

Source: common.xml. Frames: local NED about the origin; global ones are WGS 84 and above sea level.
"""

from __future__ import annotations

import math

from companion.mavlink.framing import Fields
from sitl.flight.physics import FlightState
from sitl.link.vehicle import SimulatedVehicle

NAN = math.nan
LOCAL_NED, BODY_FRD = 1, 12  # MAV_FRAME
UNKNOWN_COVARIANCE = (NAN, *(0.0,) * 20)


def attitude(v: SimulatedVehicle) -> Fields:
    """ATTITUDE."""
    return (v.boot_ms, *v.state.euler, *v.state.rates)


def attitude_quaternion(v: SimulatedVehicle) -> Fields:
    """ATTITUDE_QUATERNION."""
    return (v.boot_ms, *v.state.attitude, *v.state.rates)


def local_position_ned(v: SimulatedVehicle) -> Fields:
    """LOCAL_POSITION_NED about GPS_GLOBAL_ORIGIN."""
    return (v.boot_ms, *v.state.position, *v.state.velocity)


def global_position_int(v: SimulatedVehicle) -> Fields:
    """GLOBAL_POSITION_INT; relative_alt is above home."""
    lat, lon, alt = v.origin.to_global(v.state.position)
    north, east, down = v.state.velocity
    return (
        v.boot_ms,
        round(lat * 1e7),
        round(lon * 1e7),
        round(alt * 1e3),
        round((v.autopilot.home[2] - v.state.position[2]) * 1e3),
        round(north * 1e2),
        round(east * 1e2),
        round(down * 1e2),
        round(_heading_deg(v.state) * 1e2) % 36000,
    )


def gps_global_origin(v: SimulatedVehicle) -> Fields:
    """GPS_GLOBAL_ORIGIN of the local frame."""
    return (
        round(v.origin.latitude_deg * 1e7),
        round(v.origin.longitude_deg * 1e7),
        round(v.origin.altitude_m * 1e3),
        v.boot_us,
    )


def home_position(v: SimulatedVehicle) -> Fields:
    """HOME_POSITION: where the vehicle was armed, global and local."""
    lat, lon, alt = v.origin.to_global(v.autopilot.home)
    return (
        round(lat * 1e7),
        round(lon * 1e7),
        round(alt * 1e3),
        *v.autopilot.home,
        (1.0, 0.0, 0.0, 0.0),
        NAN,
        NAN,
        NAN,
        v.boot_us,
    )


def altitude(v: SimulatedVehicle) -> Fields:
    """ALTITUDE; terrain is flat at home's height."""
    up = -v.state.position[2]
    amsl, above_home = v.origin.altitude_m + up, up + v.autopilot.home[2]
    return (v.boot_us, amsl, amsl, up, above_home, NAN, NAN)


def vfr_hud(v: SimulatedVehicle) -> Fields:
    """VFR_HUD; as a multicopter measures no airspeed, the field has the ground speed."""
    north, east, down = v.state.velocity
    speed = math.hypot(north, east)
    throttle = round(100 * sum(v.state.motors) / 4)
    heading_deg = round(_heading_deg(v.state)) % 360
    amsl = v.origin.altitude_m - v.state.position[2]
    return (speed, speed, heading_deg, throttle, amsl, -down)


def odometry(v: SimulatedVehicle) -> Fields:
    """ODOMETRY: pose in local NED, velocities along the body's axes; resets of the position."""
    return (
        v.boot_us,
        LOCAL_NED,
        BODY_FRD,
        *v.state.position,
        v.state.attitude,
        *in_body(v.state),
        *v.state.rates,
        UNKNOWN_COVARIANCE,
        UNKNOWN_COVARIANCE,
        v.estimator.resets % 256,
        8,  # MAV_ESTIMATOR_TYPE_AUTOPILOT
    )


def in_body(state: FlightState) -> tuple[float, float, float]:
    """The velocity along the body's forward, right and down axes, m/s."""
    w, x, y, z = state.attitude
    n, e, d = state.velocity
    return (
        (1 - 2 * (y * y + z * z)) * n + 2 * (x * y + w * z) * e + 2 * (x * z - w * y) * d,
        2 * (x * y - w * z) * n + (1 - 2 * (x * x + z * z)) * e + 2 * (y * z + w * x) * d,
        2 * (x * z + w * y) * n + 2 * (y * z - w * x) * e + (1 - 2 * (x * x + y * y)) * d,
    )


def _heading_deg(state: FlightState) -> float:
    return math.degrees(state.euler[2]) % 360
