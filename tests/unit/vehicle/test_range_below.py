"""What a range finder says that looks down."""

from __future__ import annotations

import math

import pytest

from companion.mavlink.framing import Message, dialect
from companion.vehicle.range_below import DOWN, FRESH_S, INVALID, RangeBelow

AHEAD = dialect.MAV_SENSOR_ROTATION_NONE


def reading(cm: int, orientation: int = DOWN, quality: int = 0) -> Message:
    """0.2 to 12 m."""
    return dialect.MAVLink_distance_sensor_message(
        0, 20, 1200, cm, 0, 0, orientation, 0, signal_quality=quality
    )


def heard(*cm: int, tilt_rad: float = 0.0) -> float | None:
    """After readings 0.1 s apart."""
    below = RangeBelow()
    for i, each in enumerate(cm):
        below.take(i / 10, reading(each), tilt_rad)
    return below.at((len(cm) - 1) / 10)


def test_of_two_readings_the_greater_one_counts() -> None:
    assert heard(200, 150) == 2.0
    assert heard(200, 150, 140) == 1.5
    assert heard(200, 10, 200) == 2.0, "a single echo is none"
    assert heard(30) == math.inf, "neither is the first"


def test_it_is_measured_along_the_vehicle_s_own_axis() -> None:
    assert heard(200, 200, tilt_rad=math.radians(60)) == pytest.approx(1.0)


def test_too_far_is_nothing_below_and_too_near_is_no_more_than_its_least() -> None:
    assert heard(1201, 1201) == math.inf
    assert heard(10, 5) == 0.2


def test_what_is_no_reading_of_what_is_below_says_nothing() -> None:
    below = RangeBelow()
    for message in (reading(100, AHEAD), reading(100, quality=INVALID), reading(0)):
        below.take(0.0, message, 0.0)
        below.take(0.1, message, 0.0)
        assert below.at(0.1) is None


def test_old_readings_say_nothing_and_do_not_count_with_a_new_one() -> None:
    below = RangeBelow()
    for now_s in (0.0, 0.1):
        below.take(now_s, reading(30), 0.0)
    assert below.at(0.1 + FRESH_S) == 0.3
    late_s = 0.2 + FRESH_S
    assert below.at(late_s) is None
    below.take(late_s, reading(30), 0.0)
    assert below.at(late_s) == math.inf
