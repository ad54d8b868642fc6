"""What does each telemetry message say about the vehicle?

One small function for each message, vehicle in, pymavlink message out; `MESSAGES` lists them by
MAVLink's names. Units on the wire are those of common.xml (mm, cm/s, 1e7 degrees, centidegrees).
A value that is not known is sent as the message's own "unknown", never as 0 or full.

Sources: common.xml; for SYS_STATUS what MAVSDK's health checks and MAVProxy's fence need. Sensors
are free of noise.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from companion.geometry import GlobalOrigin, euler_from_quaternion, wrap_angle
from companion.mavlink.framing import Message, dialect
from companion.mavlink.px4_modes import custom_mode
from sitl.autopilot.autopilot import Autopilot
from sitl.flight.physics import FlightState

FULL_VOLTAGES = 10  # length of BATTERY_STATUS.voltages
UNKNOWN_16 = 65535
NAN = math.nan
CELLS = 4

_BASE_MODES = {"OFFBOARD": 0x11, "MANUAL": 0x41, "ACRO": 0x41}  # seen on PX4
_BASE_MODE_AUTO, _BASE_MODE_STICKS, _ARMED = 0x1D, 0x51, 0x80

# MAV_SYS_STATUS_SENSOR bits: gyro, accelerometer, magnetometer, pressure, GPS, motor outputs,
# geofence, AHRS, battery.
_SENSORS = 0x1 | 0x2 | 0x4 | 0x8 | 0x20 | 0x8000 | 0x100000 | 0x200000 | 0x2000000
_PREARM_CHECK = 0x10000000
# MAV_PROTOCOL_CAPABILITY bits: PARAM_FLOAT, MISSION_INT, COMMAND_INT, PARAM_ENCODE_BYTEWISE,
# SET_POSITION_TARGET_LOCAL_NED, MAVLINK2.
CAPABILITIES = 2 | 4 | 8 | 16 | 128 | 8192
PX4_VERSION = 0x01100000  # 1.16.0, development: the PX4 whose behaviour this is
STANDBY, ACTIVE, CRITICAL = 3, 4, 5  # MAV_STATE
_SHOWN_AS = {"DESCEND": "AUTO.LAND"}  # MAVLink has no mode of this name


@dataclass(slots=True)
class Vehicle:
    """What the messages are made of; `state` is replaced every step."""

    autopilot: Autopilot
    state: FlightState
    origin: GlobalOrigin

    @property
    def boot_ms(self) -> int:
        """Time since start, ms."""
        return round(self.state.time_s * 1e3)

    @property
    def boot_us(self) -> int:
        """Time since start, us."""
        return round(self.state.time_s * 1e6)


def status(autopilot: Autopilot) -> tuple[bool, str, int]:
    """Armed, mode and MAV_STATE: a change of any of them is told at once."""
    mode = _SHOWN_AS.get(autopilot.mode, autopilot.mode)
    if not autopilot.is_armed:
        return (False, mode, STANDBY)
    return (True, mode, CRITICAL if autopilot.is_failsafe else ACTIVE)


def heartbeat(v: Vehicle) -> Message:
    """HEARTBEAT of a PX4 quadrotor."""
    is_armed, mode, state = status(v.autopilot)
    other = _BASE_MODE_AUTO if mode.startswith("AUTO.") else _BASE_MODE_STICKS
    base = _BASE_MODES.get(mode, other) | (_ARMED if is_armed else 0)
    return dialect.MAVLink_heartbeat_message(2, 12, base, custom_mode(mode), state, 3)


def sys_status(v: Vehicle) -> Message:
    """SYS_STATUS: sensors, battery."""
    ready = _PREARM_CHECK if v.autopilot.objection() is None else 0
    return dialect.MAVLink_sys_status_message(
        _SENSORS | _PREARM_CHECK,
        _SENSORS | _PREARM_CHECK,
        _SENSORS | ready,
        0,
        round(v.state.voltage_v * 1e3),
        round(v.state.current_a * 1e2),
        _percent(v.state.charge),
        *(0,) * 6,
    )


def battery_status(v: Vehicle) -> Message:
    """BATTERY_STATUS of the one lithium polymer pack."""
    cell_mv = round(v.state.voltage_v / CELLS * 1e3)
    return dialect.MAVLink_battery_status_message(
        id=0,
        battery_function=1,
        type=1,
        temperature=32767,
        voltages=[cell_mv] * CELLS + [UNKNOWN_16] * (FULL_VOLTAGES - CELLS),
        current_battery=round(v.state.current_a * 1e2),
        current_consumed=-1,
        energy_consumed=-1,
        battery_remaining=_percent(v.state.charge),
        charge_state=int(v.autopilot.battery),
    )


def attitude(v: Vehicle) -> Message:
    """ATTITUDE."""
    return dialect.MAVLink_attitude_message(
        v.boot_ms, *euler_from_quaternion(v.state.attitude), *v.state.rates
    )


def attitude_quaternion(v: Vehicle) -> Message:
    """ATTITUDE_QUATERNION."""
    return dialect.MAVLink_attitude_quaternion_message(v.boot_ms, *v.state.attitude, *v.state.rates)


def local_position_ned(v: Vehicle) -> Message:
    """LOCAL_POSITION_NED, origin at the simulator's home."""
    return dialect.MAVLink_local_position_ned_message(
        v.boot_ms, *v.state.position, *v.state.velocity
    )


def global_position_int(v: Vehicle) -> Message:
    """GLOBAL_POSITION_INT; relative_alt is above home."""
    lat, lon, alt = v.origin.to_global(v.state.position)
    north, east, down = v.state.velocity
    return dialect.MAVLink_global_position_int_message(
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


def gps_raw_int(v: Vehicle) -> Message:
    """GPS_RAW_INT: a 3D fix of ten satellites."""
    lat, lon, alt = v.origin.to_global(v.state.position)
    north, east, _ = v.state.velocity
    course_deg = math.degrees(math.atan2(east, north)) % 360
    return dialect.MAVLink_gps_raw_int_message(
        v.boot_us,
        3,
        round(lat * 1e7),
        round(lon * 1e7),
        round(alt * 1e3),
        90,
        180,
        round(math.hypot(north, east) * 1e2),
        round(course_deg * 1e2) % 36000,
        10,
    )


def gps_global_origin(v: Vehicle) -> Message:
    """GPS_GLOBAL_ORIGIN of the local frame."""
    return dialect.MAVLink_gps_global_origin_message(
        round(v.origin.latitude_deg * 1e7),
        round(v.origin.longitude_deg * 1e7),
        round(v.origin.altitude_m * 1e3),
        v.boot_us,
    )


def home_position(v: Vehicle) -> Message:
    """HOME_POSITION: where the vehicle was armed, global and local."""
    lat, lon, alt = v.origin.to_global(v.autopilot.home)
    return dialect.MAVLink_home_position_message(
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


_LANDED_STATES = {"AUTO.TAKEOFF": 3, "AUTO.LAND": 4}


def extended_sys_state(v: Vehicle) -> Message:
    """EXTENDED_SYS_STATE: 1 on the ground, 2 in the air, 3 taking off, 4 landing."""
    landed = 1 if v.autopilot.is_landed else _LANDED_STATES.get(v.autopilot.mode, 2)
    return dialect.MAVLink_extended_sys_state_message(0, landed)


def altitude(v: Vehicle) -> Message:
    """ALTITUDE; terrain is flat at home's height."""
    up = -v.state.position[2]
    amsl, above_home = v.origin.altitude_m + up, up + v.autopilot.home[2]
    return dialect.MAVLink_altitude_message(v.boot_us, amsl, amsl, up, above_home, NAN, NAN)


def vfr_hud(v: Vehicle) -> Message:
    """VFR_HUD; a multicopter reports no airspeed of its own, so ground speed stands there."""
    north, east, down = v.state.velocity
    speed = math.hypot(north, east)
    throttle = round(100 * sum(v.autopilot.motors) / 4)
    heading_deg = round(_heading_deg(v.state)) % 360
    amsl = v.origin.altitude_m - v.state.position[2]
    return dialect.MAVLink_vfr_hud_message(speed, speed, heading_deg, throttle, amsl, -down)


def highres_imu(v: Vehicle) -> Message:
    """HIGHRES_IMU: accelerometer and gyroscope; the other fields are marked as not updated."""
    return dialect.MAVLink_highres_imu_message(
        v.boot_us, *v.state.specific_force, *v.state.rates, *(NAN,) * 7, 0x3F
    )


def system_time(v: Vehicle) -> Message:
    """SYSTEM_TIME; the simulated world has no calendar, so Unix time is 0, unknown."""
    return dialect.MAVLink_system_time_message(0, v.boot_ms)


def position_target_local_ned(v: Vehicle) -> Message:
    """POSITION_TARGET_LOCAL_NED: what the control cascade follows, NaN where nothing."""
    target = v.autopilot.target
    nothing = (None, None, None)
    position = target.position if target else nothing
    velocity = target.velocity if target else nothing
    return dialect.MAVLink_position_target_local_ned_message(
        v.boot_ms,
        1,
        0,
        *(_or_nan(x) for x in (*position, *velocity)),
        *(target.acceleration if target else (NAN, NAN, NAN)),
        _or_nan(target.yaw_rad if target else None),
        _or_nan(target.yaw_rate_radps if target else None),
    )


def servo_output_raw(v: Vehicle) -> Message:
    """SERVO_OUTPUT_RAW: motor commands as 1000 to 2000 us."""
    pulses = (round(1000 + 1000 * motor) for motor in v.autopilot.motors)
    return dialect.MAVLink_servo_output_raw_message(v.boot_us % 2**32, 0, *pulses, *(0,) * 4)


def mission_current(v: Vehicle) -> Message:
    """MISSION_CURRENT: no mission."""
    return dialect.MAVLink_mission_current_message(seq=0, total=0, mission_state=1)


def autopilot_version(v: Vehicle) -> Message:
    """AUTOPILOT_VERSION: what is really served, and which PX4 this behaves like."""
    nothing = (0,) * 8
    return dialect.MAVLink_autopilot_version_message(
        CAPABILITIES, PX4_VERSION, PX4_VERSION, 0, 1, nothing, nothing, nothing, 0, 0, 1
    )


MESSAGES: dict[str, Callable[[Vehicle], Message]] = {
    "HEARTBEAT": heartbeat,
    "SYS_STATUS": sys_status,
    "BATTERY_STATUS": battery_status,
    "ATTITUDE": attitude,
    "ATTITUDE_QUATERNION": attitude_quaternion,
    "LOCAL_POSITION_NED": local_position_ned,
    "GLOBAL_POSITION_INT": global_position_int,
    "GPS_RAW_INT": gps_raw_int,
    "GPS_GLOBAL_ORIGIN": gps_global_origin,
    "HOME_POSITION": home_position,
    "EXTENDED_SYS_STATE": extended_sys_state,
    "ALTITUDE": altitude,
    "VFR_HUD": vfr_hud,
    "HIGHRES_IMU": highres_imu,
    "SYSTEM_TIME": system_time,
    "POSITION_TARGET_LOCAL_NED": position_target_local_ned,
    "SERVO_OUTPUT_RAW": servo_output_raw,
    "MISSION_CURRENT": mission_current,
    "AUTOPILOT_VERSION": autopilot_version,
}
"""Name -> maker: what can be requested. Those with a rate in streams.py are also streamed."""


def message_name(message_id: int) -> str | None:
    """Name of a message that can be requested, None for any other id."""
    known = dialect.mavlink_map.get(message_id)
    return known.msgname if known and known.msgname in MESSAGES else None


def _percent(charge: float) -> int:
    return min(100, max(0, math.ceil(charge * 100)))


def _heading_deg(state: FlightState) -> float:
    return math.degrees(wrap_angle(euler_from_quaternion(state.attitude)[2])) % 360


def _or_nan(value: float | None) -> float:
    return NAN if value is None else value
