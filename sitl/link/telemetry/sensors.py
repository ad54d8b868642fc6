"""What do the sensors measure?

Source: common.xml. A value that is not measured is sent as the message's own "unknown".
"""

from __future__ import annotations

import math

from companion.mavlink.framing import Message, dialect
from sitl.link.vehicle import Vehicle

NAN = math.nan


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


def highres_imu(v: Vehicle) -> Message:
    """HIGHRES_IMU: accelerometer and gyroscope; the other fields are marked as not updated."""
    return dialect.MAVLink_highres_imu_message(
        v.boot_us, *v.state.specific_force, *v.state.rates, *(NAN,) * 7, 0x3F
    )


def distance_sensor(v: Vehicle) -> Message:
    """DISTANCE_SENSOR: a laser that looks down, to 50 m."""
    height_cm = round(max(0.0, -v.state.position[2]) * 100)
    return dialect.MAVLink_distance_sensor_message(
        v.boot_ms, 10, 5000, min(height_cm, 5001), 0, 0, 25, 0
    )


def estimator_status(v: Vehicle) -> Message:
    """ESTIMATOR_STATUS: attitude and height are always good, the rest while there is a position."""
    attitude, height = 0x1, 0x4 | 0x20
    horizontal = 0x2 | 0x8 | 0x10 | 0x100 | 0x200
    flags = attitude | height | (0 if v.autopilot.is_position_lost else horizontal)
    return dialect.MAVLink_estimator_status_message(v.boot_us, flags, *(0.1,) * 6, 0.5, 0.5)


def vibration(v: Vehicle) -> Message:
    """VIBRATION: none."""
    return dialect.MAVLink_vibration_message(v.boot_us, 0.0, 0.0, 0.0, 0, 0, 0)
