"""What the velocity is off by: found where it is, and nothing where the two agree."""

from __future__ import annotations

import math
from collections.abc import Callable
from random import Random

import pytest
from hypothesis import given
from hypothesis import strategies as st

from companion.vehicle.velocity_bias import (
    FRESH_S,
    IGNORED_MPS,
    JUMP_M,
    MOST_MPS,
    SMOOTH_S,
    VelocityBias,
)

PERIOD_S = 1 / 30
FLAT, NOTHING = (0.0, 0.0), (0.0, 0.0, 0.0)
Flat = Callable[[float], tuple[float, float]]


def flown(
    position: Flat,
    velocity: Flat,
    until_s: float = 5.0,
    period: Callable[[], float] = lambda: PERIOD_S,
) -> tuple[VelocityBias, float]:
    """What is known after reports of a motion, and when the last one was heard."""
    bias, time_s = VelocityBias(), 100.0
    while True:
        t = time_s - 100.0
        bias.take(time_s, time_s, (*position(t), -2.0), (*velocity(t), 0.0))
        if t >= until_s:
            return bias, time_s
        time_s += period()


@pytest.mark.parametrize("heading", range(0, 360, 45))
def test_a_vehicle_that_moves_as_its_velocity_does_not_say(heading: int) -> None:
    """It reports to stand, and moves at 0.35 m/s: that much has to be added the other way."""
    north, east = math.cos(math.radians(heading)), math.sin(math.radians(heading))
    bias, now_s = flown(lambda t: (0.35 * north * t, 0.35 * east * t), lambda _: FLAT)
    counted = -(0.35 - IGNORED_MPS)
    assert bias.at(now_s) == pytest.approx((counted * north, counted * east, 0.0), abs=1e-3)


def test_the_vertical_is_one_of_three() -> None:
    bias = VelocityBias()
    for number in range(150):
        bias.take(number / 30, number / 30, (0.0, 0.0, -2.0 - 0.2 * number / 30), (0.0, 0.0, 0.0))
    assert bias.at(149 / 30) == pytest.approx((0.0, 0.0, 0.2 - IGNORED_MPS), abs=1e-3)


def test_no_more_than_the_most_is_added() -> None:
    bias, now_s = flown(lambda t: (-2.0 * t, 0.0), lambda _: FLAT)
    assert bias.at(now_s) == pytest.approx((MOST_MPS, 0.0, 0.0))


def test_nothing_is_added_for_rounding() -> None:
    bias, now_s = flown(lambda t: (0.0, 0.9 * IGNORED_MPS * t), lambda _: FLAT)
    assert bias.at(now_s) == NOTHING


@given(
    amplitude_m=st.floats(0.1, 8.0),
    pace=st.floats(0.05, 1.2),
    seed=st.integers(0, 1000),
)
def test_nothing_is_off_where_velocity_and_position_agree(
    amplitude_m: float, pace: float, seed: int
) -> None:
    """Circles with up to 9.6 m/s and 4 m/s2, reported at uneven times."""
    if amplitude_m * pace**2 > 4.0:
        pace = math.sqrt(4.0 / amplitude_m)
    random = Random(seed)
    bias, now_s = flown(
        lambda t: (amplitude_m * math.cos(pace * t), amplitude_m * math.sin(pace * t)),
        lambda t: (
            -amplitude_m * pace * math.sin(pace * t),
            amplitude_m * pace * math.cos(pace * t),
        ),
        period=lambda: random.uniform(0.02, 0.1),
    )
    assert bias.at(now_s) == NOTHING


def test_it_follows_within_its_time_constant() -> None:
    bias, now_s = flown(lambda t: (0.3 * max(0.0, t - 4.0), 0.0), lambda _: FLAT, 4.0 + SMOOTH_S)
    assert bias.at(now_s)[0] == pytest.approx(-0.3 * (1 - math.exp(-1)) + IGNORED_MPS, abs=0.02)


@pytest.mark.parametrize("by_m", [JUMP_M + 0.1, 50.0])
def test_a_position_set_elsewhere_is_no_motion(by_m: float) -> None:
    bias, now_s = flown(lambda t: (by_m if t > 4.0 else 0.0, 0.1 * t), lambda _: (0.0, 0.1))
    assert bias.at(now_s) == NOTHING


def test_a_jump_does_not_forget_what_is_off() -> None:
    bias, now_s = flown(lambda t: (0.3 * t + (9.0 if t > 4.0 else 0.0), 0.0), lambda _: FLAT)
    assert bias.at(now_s)[0] == pytest.approx(-0.3 + IGNORED_MPS, abs=5e-3)


def test_nothing_is_known_before_some_reports_in_a_row() -> None:
    assert VelocityBias().at(0.0) == NOTHING
    bias, now_s = flown(lambda t: (0.4 * t, 0.0), lambda _: FLAT, 0.9 * SMOOTH_S)
    assert bias.at(now_s) == NOTHING
    bias, now_s = flown(lambda t: (0.4 * t, 0.0), lambda _: FLAT, 1.2 * SMOOTH_S)
    assert bias.at(now_s) != NOTHING


def test_what_is_old_is_not_added() -> None:
    bias, heard_s = flown(lambda t: (0.4 * t, 0.0), lambda _: FLAT)
    assert bias.at(heard_s + FRESH_S) != NOTHING
    assert bias.at(heard_s + FRESH_S + 1e-6) == NOTHING


def test_a_report_that_comes_twice_is_one() -> None:
    bias, now_s = flown(lambda t: (0.4 * t, 0.0), lambda _: FLAT)
    before = bias.at(now_s)
    bias.take(now_s, now_s, (99.0, 0.0, -2.0), (9.0, 0.0, 0.0))
    assert bias.at(now_s) == before


@pytest.mark.parametrize("step_s", [FRESH_S + 1e-6, -1.0])
def test_after_a_gap_or_a_reboot_it_begins_anew(step_s: float) -> None:
    bias, heard_s = flown(lambda t: (0.4 * t, 0.0), lambda _: FLAT)
    bias.take(heard_s, heard_s + step_s, (2.0, 0.0, -2.0), (0.0, 0.0, 0.0))
    assert bias.at(heard_s) == NOTHING
