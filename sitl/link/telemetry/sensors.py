"""Telemetry of the sensors.

Source: common.xml. A value that is not measured is sent as the message's own "unknown".
"""

from __future__ import annotations

import math

from companion.mavlink.framing import Fields
from sitl.link.vehicle import SimulatedVehicle

NAN = math.nan
UNKNOWN_16 = 65535
HEIGHT_ACCURACY_M = 0.5
GPS_VERTICAL_ACCURACY_M, GPS_SPEED_ACCURACY_MPS = 1.78, 0.4  # SensorGpsSim's epv, s_variance
NO_FIX, FIX_3D = 1, 3  # GPS_FIX_TYPE
RANGE_M = 50.0  # of the downward range finder
IMU_AND_BAROMETER = 0x3F | 0x200 | 0x800 | 0x1000  # HIGHRES_IMU.fields_updated


def gps_raw_int(v: SimulatedVehicle) -> Fields:
    """GPS_RAW_INT: the receiver's report."""
    gps = v.sensors.gps
    north, east, _ = gps.velocity
    course_deg = math.degrees(math.atan2(east, north)) % 360
    return (
        v.boot_us,
        FIX_3D if gps.is_3d else NO_FIX,
        round(gps.latitude_deg * 1e7),
        round(gps.longitude_deg * 1e7),
        round(gps.altitude_m * 1e3),
        90 if gps.is_3d else UNKNOWN_16,
        180 if gps.is_3d else UNKNOWN_16,
        round(math.hypot(north, east) * 1e2),
        round(course_deg * 1e2) % 36000,
        gps.satellites,
        round(gps.altitude_m * 1e3),
        round(gps.horizontal_accuracy_m * 1e3),
        round(GPS_VERTICAL_ACCURACY_M * 1e3),
        round(GPS_SPEED_ACCURACY_MPS * 1e3),
    )


def highres_imu(v: SimulatedVehicle) -> Fields:
    """HIGHRES_IMU; the magnetometer and the airspeed sensor are marked as not updated."""
    imu, air = v.sensors.imu, v.sensors.barometer
    return (
        v.boot_us,
        *imu.specific_force,
        *imu.rates,
        *(NAN, NAN, NAN),
        air.pressure_pa / 100,
        NAN,
        air.altitude_m,
        air.temperature_degc,
        IMU_AND_BAROMETER,
    )


def scaled_pressure(v: SimulatedVehicle) -> Fields:
    """SCALED_PRESSURE, hPa and centidegrees."""
    air = v.sensors.barometer
    return (v.boot_ms, air.pressure_pa / 100, 0.0, round(air.temperature_degc * 100))


def distance_sensor(v: SimulatedVehicle) -> Fields:
    """DISTANCE_SENSOR: a laser that points down, with a range of 50 m."""
    range_cm = round(min(v.sensors.range_below_m, RANGE_M + 0.01) * 100)
    return (v.boot_ms, 10, round(RANGE_M * 100), range_cm, 0, 0, 25, 0)


def estimator_status(v: SimulatedVehicle) -> Fields:
    """ESTIMATOR_STATUS: attitude and height are always good, the rest while there is a position."""
    attitude, height = 0x1, 0x4 | 0x20
    horizontal = 0x2 | 0x8 | 0x10 | 0x100 | 0x200
    flags = attitude | height | (0 if v.autopilot.health.is_position_lost else horizontal)
    return (v.boot_us, flags, *(0.1,) * 6, v.estimator.accuracy_m, HEIGHT_ACCURACY_M)


def vibration(v: SimulatedVehicle) -> Fields:
    """VIBRATION: none."""
    return (v.boot_us, 0.0, 0.0, 0.0, 0, 0, 0)
