"""The table of telemetry messages.

Each message is a small function in sitl/link/telemetry: the vehicle in, the message's fields out.
The table lists them by MAVLink's names. Units on the wire are those of common.xml (mm, cm/s, 1e7
degrees, centidegrees). An unknown value is sent as the message's own "unknown", never as 0 or full.
"""

from __future__ import annotations

from collections.abc import Callable

from companion.mavlink.framing import Fields, Message, dialect
from sitl.link.telemetry import control, motion, sensors, system
from sitl.link.vehicle import SimulatedVehicle

MESSAGES: dict[str, Callable[[SimulatedVehicle], Fields]] = {
    "HEARTBEAT": system.heartbeat,
    "SYS_STATUS": system.sys_status,
    "BATTERY_STATUS": system.battery_status,
    "EXTENDED_SYS_STATE": system.extended_sys_state,
    "MISSION_CURRENT": system.mission_current,
    "AUTOPILOT_VERSION": system.autopilot_version,
    "FLIGHT_INFORMATION": system.flight_information,
    "SYSTEM_TIME": system.system_time,
    "PING": system.ping,
    "TIMESYNC": system.timesync,
    "ATTITUDE": motion.attitude,
    "ATTITUDE_QUATERNION": motion.attitude_quaternion,
    "LOCAL_POSITION_NED": motion.local_position_ned,
    "GLOBAL_POSITION_INT": motion.global_position_int,
    "GPS_GLOBAL_ORIGIN": motion.gps_global_origin,
    "HOME_POSITION": motion.home_position,
    "ALTITUDE": motion.altitude,
    "VFR_HUD": motion.vfr_hud,
    "ODOMETRY": motion.odometry,
    "GPS_RAW_INT": sensors.gps_raw_int,
    "HIGHRES_IMU": sensors.highres_imu,
    "SCALED_PRESSURE": sensors.scaled_pressure,
    "DISTANCE_SENSOR": sensors.distance_sensor,
    "ESTIMATOR_STATUS": sensors.estimator_status,
    "VIBRATION": sensors.vibration,
    "POSITION_TARGET_LOCAL_NED": control.position_target_local_ned,
    "ATTITUDE_TARGET": control.attitude_target,
    "SERVO_OUTPUT_RAW": control.servo_output_raw,
    "ACTUATOR_OUTPUT_STATUS": control.actuator_output_status,
}
"""Name -> maker, for all that can be requested. Those with a rate in streams.py are streamed too.
"""

MESSAGE_CLASSES = {
    kind.msgname: kind for kind in dialect.mavlink_map.values() if kind.msgname in MESSAGES
}
"""Name -> pymavlink's class."""


def compose(name: str, vehicle: SimulatedVehicle) -> Message:
    """A message by its name, with the present values."""
    return MESSAGE_CLASSES[name](*MESSAGES[name](vehicle))


def message_name(message_id: int) -> str | None:
    """Name of a message that can be requested, None for any other id."""
    known = dialect.mavlink_map.get(message_id)
    return known.msgname if known and known.msgname in MESSAGES else None
