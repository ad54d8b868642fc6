"""Headings: the shorter way round, no faster than allowed, and towards a point."""

from __future__ import annotations

import math

from hypothesis import assume, given
from hypothesis import strategies as st
from pytest import approx

from companion.motion.heading import FACING_M, error_rad, towards, turned

angles = st.floats(-math.pi, math.pi)


@given(angles, angles, st.floats(0.02, 0.2))
def test_a_turn_takes_the_shorter_way_in_steps_of_the_rate(
    now_rad: float, wanted_rad: float, most_rad: float
) -> None:
    total_rad, steps = error_rad(now_rad, wanted_rad), 0
    while (left_rad := error_rad(now_rad, wanted_rad)) > 1e-9:
        before_rad, now_rad, steps = now_rad, turned(now_rad, wanted_rad, most_rad), steps + 1
        assert -math.pi < now_rad <= math.pi
        assert error_rad(before_rad, now_rad) == approx(min(most_rad, left_rad), abs=1e-9)
    assert steps <= math.ceil(total_rad / most_rad) + 1
    assert total_rad <= math.pi + 1e-9


@given(*[st.floats(-50, 50)] * 4)
def test_who_goes_where_he_looks_comes_to_the_point(
    north: float, east: float, to_north: float, to_east: float
) -> None:
    away_m = math.hypot(to_north - north, to_east - east)
    assume(away_m >= FACING_M)
    heading_rad = towards((north, east, -2.0), (to_north, to_east))
    assert heading_rad is not None
    there = (north + away_m * math.cos(heading_rad), east + away_m * math.sin(heading_rad))
    assert there == approx((to_north, to_east), abs=1e-6)


def test_a_point_below_the_vehicle_is_in_no_direction() -> None:
    assert towards((3.0, 4.0, -2.0), (3.0, 4.0)) is None
    assert towards((3.0, 4.0, -2.0), (3.0, 4.0 + FACING_M)) is not None
