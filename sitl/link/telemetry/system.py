"""Telemetry of the system: mode, health, battery, versions, clocks.

Sources: common.xml; messages of a PX4; for SYS_STATUS, what MAVSDK's health checks and MAVProxy's
fence need.
"""

from __future__ import annotations

import math

from companion.mavlink.framing import Fields
from companion.mavlink.px4_modes import custom_mode
from sitl.autopilot.autopilot import Autopilot
from sitl.link.vehicle import SimulatedVehicle

CELLS = 4
CHARGING = 7  # MAV_BATTERY_CHARGE_STATE
FULL_VOLTAGES = 10  # length of BATTERY_STATUS.voltages
UNKNOWN_16 = 65535

_BASE_MODES = {"OFFBOARD": 0x11, "MANUAL": 0x41, "ACRO": 0x41}  # seen on PX4
_BASE_MODE_AUTO, _BASE_MODE_STICKS, _ARMED = 0x1D, 0x51, 0x80

# MAV_SYS_STATUS_SENSOR bits: gyro, accelerometer, magnetometer, pressure, GPS, motor outputs,
# geofence, AHRS, battery.
_SENSORS = 0x1 | 0x2 | 0x4 | 0x8 | 0x20 | 0x8000 | 0x100000 | 0x200000 | 0x2000000
_GPS, _GEOFENCE, _PREARM_CHECK = 0x20, 0x100000, 0x10000000
# MAV_PROTOCOL_CAPABILITY bits: PARAM_FLOAT, MISSION_INT, COMMAND_INT, PARAM_ENCODE_BYTEWISE,
# SET_POSITION_TARGET_LOCAL_NED, SET_POSITION_TARGET_GLOBAL_INT, MAVLINK2.
CAPABILITIES = 2 | 4 | 8 | 16 | 128 | 256 | 8192 | 16384 | 32768
PX4_VERSION = 0x011000C0  # 1.16.0: the PX4 whose behaviour this is
STANDBY, ACTIVE, CRITICAL = 3, 4, 5  # MAV_STATE
_SHOWN_AS = {"DESCEND": "AUTO.LAND"}  # MAVLink has no mode of this name


def status(autopilot: Autopilot) -> tuple[bool, str, int]:
    """Armed, mode and MAV_STATE; a change of any of them is sent at once."""
    mode = _SHOWN_AS.get(autopilot.mode, autopilot.mode)
    if not autopilot.is_armed:
        return (False, mode, STANDBY)
    return (True, mode, CRITICAL if autopilot.is_failsafe else ACTIVE)


def heartbeat(v: SimulatedVehicle) -> Fields:
    """HEARTBEAT of a PX4 quadrotor."""
    is_armed, mode, state = status(v.autopilot)
    other = _BASE_MODE_AUTO if mode.startswith("AUTO.") else _BASE_MODE_STICKS
    base = _BASE_MODES.get(mode, other) | (_ARMED if is_armed else 0)
    return (2, 12, base, custom_mode(mode), state, 3)


def sys_status(v: SimulatedVehicle) -> Fields:
    """SYS_STATUS: sensors, battery."""
    ready = 0 if v.autopilot.arming_denials() else _PREARM_CHECK
    unhealthy = (_GPS if v.autopilot.health.is_position_lost else 0) | (
        _GEOFENCE if v.autopilot.is_fence_breached else 0
    )
    battery = (
        (round(v.state.voltage_v * 1e3), _centiamperes(v.state.current_a), _percent(v.state.charge))
        if v.autopilot.health.knows_battery
        else (UNKNOWN_16, -1, -1)
    )
    return (
        _SENSORS | _PREARM_CHECK,
        _SENSORS | _PREARM_CHECK,
        _SENSORS & ~unhealthy | ready,
        0,
        *battery,
        *(0,) * 6,
    )


def battery_status(v: SimulatedVehicle) -> Fields:
    """BATTERY_STATUS of the one lithium polymer pack; None while its gauge cannot be read."""
    if not v.autopilot.health.knows_battery:
        return (0, 1, 1, 32767, [UNKNOWN_16] * FULL_VOLTAGES, -1, -1, -1, -1, 0, 0)
    gauge = v.battery.gauge()
    cell_mv = round(v.state.voltage_v / CELLS * 1e3)
    return (
        0,
        1,  # for everything
        1,  # lithium polymer
        32767,  # no temperature
        [cell_mv] * CELLS + [UNKNOWN_16] * (FULL_VOLTAGES - CELLS),
        _centiamperes(v.state.current_a),
        round(gauge.consumed_mah),
        -1,  # PX4 reports no energy
        math.floor(v.state.charge * 100 + 0.5),
        0 if gauge.remaining_s is None else max(1, int(gauge.remaining_s)),
        CHARGING if gauge.is_charging else int(v.autopilot.health.battery),
    )


_LANDED_STATES = {"AUTO.TAKEOFF": 3, "AUTO.LAND": 4, "DESCEND": 4}


def extended_sys_state(v: SimulatedVehicle) -> Fields:
    """EXTENDED_SYS_STATE: 1 on the ground, 2 in the air, 3 taking off, 4 landing."""
    landed = 1 if v.autopilot.is_landed else _LANDED_STATES.get(v.autopilot.mode, 2)
    return (0, landed)


def mission_current(v: SimulatedVehicle) -> Fields:
    """MISSION_CURRENT: the item that is flown now or next; which plans are stored."""
    mission, mode = v.autopilot.mission, v.autopilot.mode
    return (
        mission.current,
        len(mission.items) or UNKNOWN_16,
        mission.reported_state(mode, v.state.time_s),
        1 if mission.is_active(mode) else 2,
        *v.plan_numbers.values(),
    )


def autopilot_version(v: SimulatedVehicle) -> Fields:
    """AUTOPILOT_VERSION: the capabilities served, and the PX4 version that is modelled."""
    nothing = (0,) * 8
    return (CAPABILITIES, PX4_VERSION, PX4_VERSION, 0, 1, nothing, nothing, nothing, 0, 0, 1)


def system_time(v: SimulatedVehicle) -> Fields:
    """SYSTEM_TIME; the simulated world has no calendar, so Unix time is 0, unknown."""
    return (0, v.boot_ms)


def flight_information(v: SimulatedVehicle) -> Fields:
    """FLIGHT_INFORMATION of the present flight, or of the last one; times since start."""
    flights = v.autopilot.flights
    return (v.boot_ms, round(flights.armed_s * 1e6), round(flights.in_air_s * 1e6), flights.count)


def ping(v: SimulatedVehicle) -> Fields:
    """PING to everybody, numbered by the second."""
    return (v.boot_us, v.boot_us // 1_000_000, 0, 0)


def timesync(v: SimulatedVehicle) -> Fields:
    """TIMESYNC: a request, which clients answer."""
    return (0, v.boot_us * 1000)


def _centiamperes(current_a: float) -> int:
    """Current out of the battery; never -1, which would mean unknown."""
    value = round(current_a * 1e2)
    return value if value != -1 else 0


def _percent(charge: float) -> int:
    return min(100, max(0, math.ceil(charge * 100)))
