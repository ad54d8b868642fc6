"""The last line before the wire: each rule has a test that fails without it."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from companion.geometry import Ned, distance, is_in_polygon
from companion.outcomes import Refusal
from companion.vehicle.gate import SPEED_TOLERANCE, Envelope, Verdict, admit
from companion.vehicle.port import Mode, Setpoint, VehicleState, hold_at

ENVELOPE = Envelope(
    fence=((0.0, 0.0), (0.0, 10.0), (10.0, 10.0), (10.0, 0.0)),
    up_m=(0.5, 4.0),
    speed_mps=2.0,
    climb_mps=1.5,
    descent_mps=1.0,
    carrot_m=1.5,
)
NOW_S = 100.0
STATE = VehicleState(
    NOW_S - 0.1, (5.0, 5.0, -2.25), (1.0, 0.0, 0.0), 0.3, Mode.OFFBOARD, True, False, False, 80
)
GOOD = Setpoint((5.5, 5.0, -2.25), (1.0, 0.0, 0.0), (0.5, 0.0, 0.0), 0.2)
HOLD = hold_at(STATE.position, STATE.yaw_rad)
NOT_FINITE = [math.nan, math.inf, -math.inf]


def verdict(
    setpoint: Setpoint = GOOD,
    state: VehicleState | None = STATE,
    now_s: float = NOW_S,
    is_our_mode: bool = True,
    asked_s: float = NOW_S,
) -> Verdict:
    return admit(setpoint, asked_s, state, now_s, is_our_mode, ENVELOPE)


def changed(vector: Ned, axis: int, number: float) -> Ned:
    north, east, down = (number if i == axis else old for i, old in enumerate(vector))
    return (north, east, down)


def held(refusal: str) -> Verdict:
    return Verdict(HOLD, Refusal(refusal))


def test_a_good_setpoint_passes_as_it_is() -> None:
    assert verdict() == Verdict(GOOD)


# -- nothing is sent -------------------------------------------------------------------------------


def test_without_a_position_nothing_is_sent() -> None:
    assert verdict(state=None) == Verdict(None, Refusal("the position is unknown"))


@pytest.mark.parametrize("axis", range(3))
@pytest.mark.parametrize("number", NOT_FINITE)
def test_a_position_that_is_not_finite_is_unknown(axis: int, number: float) -> None:
    state = replace(STATE, position=changed(STATE.position, axis, number))
    assert verdict(state=state) == Verdict(None, Refusal("the position is unknown"))


def test_when_the_position_was_lost_nothing_is_sent() -> None:
    """Only silence lets the autopilot's own failsafe begin."""
    stamp_s = STATE.stamp_s
    assert verdict(now_s=stamp_s + 3.1) == Verdict(None, Refusal("no position for 3.1 s"))
    assert verdict(now_s=stamp_s + 2.9).setpoint == HOLD


def test_in_a_mode_that_is_not_ours_nothing_is_sent() -> None:
    state = replace(STATE, mode=Mode.POSCTL)
    assert verdict(state=state, is_our_mode=False) == Verdict(None, Refusal("the mode is POSCTL"))


# -- hold ------------------------------------------------------------------------------------------


def test_old_telemetry_holds() -> None:
    assert verdict(now_s=STATE.stamp_s + 0.49) == Verdict(GOOD)
    assert verdict(now_s=STATE.stamp_s + 0.61) == held("the position is 0.6 s old")


def test_a_setpoint_that_nobody_renews_holds() -> None:
    assert verdict(asked_s=NOW_S - ENVELOPE.lease_s) == Verdict(GOOD)
    assert verdict(asked_s=NOW_S - 0.61) == held("not renewed for 0.6 s")
    assert verdict(asked_s=math.nan) == held("not renewed for nan s")


@pytest.mark.parametrize("field", ["position", "velocity", "acceleration"])
@pytest.mark.parametrize("axis", range(3))
@pytest.mark.parametrize("number", NOT_FINITE)
def test_a_number_that_is_not_finite_holds(field: str, axis: int, number: float) -> None:
    spoilt: dict[str, Any] = {field: changed(getattr(GOOD, field), axis, number)}
    assert verdict(replace(GOOD, **spoilt)) == held("the setpoint is not finite")


@pytest.mark.parametrize("number", NOT_FINITE)
def test_a_heading_that_is_not_finite_holds(number: float) -> None:
    assert verdict(replace(GOOD, yaw_rad=number)) == held("the setpoint is not finite")


@pytest.mark.parametrize(
    ("edge", "step"),
    [
        ((0.2, 5.0), (-0.4, 0.0)),
        ((9.8, 5.0), (0.4, 0.0)),
        ((5.0, 0.2), (0.0, -0.4)),
        ((5.0, 9.8), (0.0, 0.4)),
    ],
)
def test_each_side_of_the_fence_holds(edge: tuple[float, float], step: tuple[float, float]) -> None:
    state = replace(STATE, position=(*edge, -2.0))
    inside = replace(GOOD, position=(*edge, -2.0))
    outside = replace(GOOD, position=(edge[0] + step[0], edge[1] + step[1], -2.0))
    assert verdict(inside, state) == Verdict(inside)
    expected = Verdict(hold_at(state.position, state.yaw_rad), Refusal("outside the fence"))
    assert verdict(outside, state) == expected


@pytest.mark.parametrize(
    ("up_m", "is_within"), [(0.49, False), (0.51, True), (3.99, True), (4.01, False)]
)
def test_the_altitude_band_has_two_ends(up_m: float, is_within: bool) -> None:
    state = replace(STATE, position=(5.0, 5.0, -min(max(up_m, 1.0), 3.5)))
    setpoint = replace(GOOD, position=(5.0, 5.0, -up_m))
    found = verdict(setpoint, state)
    assert (found.setpoint == setpoint) is is_within
    assert found.refusal == (None if is_within else Refusal("outside the altitude band"))


@pytest.mark.parametrize("axis", range(3))
@pytest.mark.parametrize("sign", [-1, 1])
def test_the_carrot_reaches_equally_far_in_every_direction(axis: int, sign: int) -> None:
    def beside(gap_m: float) -> Setpoint:
        along = STATE.position[axis] + sign * gap_m
        return replace(GOOD, position=changed(STATE.position, axis, along))

    assert verdict(beside(1.45)).refusal is None
    assert verdict(beside(1.61)) == held("1.6 m from the vehicle")


def test_the_carrot_is_a_ball_and_not_a_box() -> None:
    corner = replace(GOOD, position=(6.0, 6.0, -3.25))
    assert verdict(corner) == held("1.7 m from the vehicle")


@pytest.mark.parametrize("velocity", [(0.0, 0.0, -2.1), (1.5, -1.5, 0.0), (-2.1, 0.0, 0.0)])
def test_more_than_the_speed_limit_holds(velocity: tuple[float, float, float]) -> None:
    assert verdict(replace(GOOD, velocity=velocity)) == held("2.1 m/s is too fast")


@pytest.mark.parametrize(
    ("down_mps", "refusal"),
    [
        (-1.5, None),
        (-1.6, "1.6 m/s up is too fast"),
        (1.0, None),
        (1.1, "1.1 m/s down is too fast"),
    ],
)
def test_climbs_and_descents_have_limits_of_their_own(down_mps: float, refusal: str | None) -> None:
    setpoint = replace(GOOD, velocity=(0.1, 0.0, down_mps))
    assert verdict(setpoint) == (held(refusal) if refusal else Verdict(setpoint))


def test_rounding_at_the_limit_does_not_stop_the_vehicle() -> None:
    velocity = (ENVELOPE.speed_mps * (SPEED_TOLERANCE + 1) / 2, 0.0, 0.0)
    assert verdict(replace(GOOD, velocity=velocity)).refusal is None


def test_what_is_exactly_at_a_limit_is_within_it() -> None:
    """At the end of each interval; the numbers are exact in binary, so rounding plays no part."""
    state = replace(STATE, stamp_s=NOW_S, position=(5.0, 5.0, -2.0))
    assert verdict(state=state, now_s=NOW_S + 0.5).setpoint == GOOD
    assert verdict(state=state, now_s=NOW_S + 3.0).setpoint is not None
    at_the_carrot = replace(GOOD, position=(6.5, 5.0, -2.0))
    assert verdict(at_the_carrot, state).refusal is None
    for down in (-0.5, -4.0):
        at_the_band = replace(GOOD, position=(5.0, 5.0, down))
        near = replace(state, position=(5.0, 5.0, (down - 2.0) / 2))
        assert verdict(at_the_band, near).refusal is None
    fastest = replace(GOOD, velocity=(ENVELOPE.speed_mps * SPEED_TOLERANCE, 0.0, 0.0))
    assert verdict(fastest).refusal is None


# -- whatever comes --------------------------------------------------------------------------------

ANY = st.floats() | st.floats(-12, 12)
VECTOR = st.tuples(ANY, ANY, ANY)
NEAR = st.tuples(st.floats(-1, 11), st.floats(-1, 11), st.floats(-5, 1))
SETPOINTS = st.builds(Setpoint, NEAR | VECTOR, VECTOR, VECTOR, ANY)
STATES = st.builds(
    replace,
    st.just(STATE),
    stamp_s=st.floats(NOW_S - 5, NOW_S),
    position=NEAR | VECTOR,
    yaw_rad=st.floats(-math.pi, math.pi),
    mode=st.sampled_from(Mode),
)


@given(setpoint=SETPOINTS, state=st.none() | STATES, is_our_mode=st.booleans())
def test_what_comes_out_is_within_all_limits_or_exactly_the_hold(
    setpoint: Setpoint, state: VehicleState | None, is_our_mode: bool
) -> None:
    found = verdict(setpoint, state, is_our_mode=is_our_mode)
    if found.setpoint is None:
        assert found.refusal
        return
    assert state is not None and is_our_mode
    sent = found.setpoint
    numbers = (*sent.position, *sent.velocity, *sent.acceleration, sent.yaw_rad)
    assert all(map(math.isfinite, numbers))
    if found.refusal:
        assert sent == hold_at(state.position, state.yaw_rad)
        return
    assert sent == setpoint
    assert NOW_S - state.stamp_s <= ENVELOPE.max_age_s
    assert is_in_polygon(sent.position, ENVELOPE.fence)
    assert ENVELOPE.up_m[0] <= -sent.position[2] <= ENVELOPE.up_m[1]
    assert distance(sent.position, state.position) <= ENVELOPE.carrot_m
    assert math.hypot(*sent.velocity) <= ENVELOPE.speed_mps * SPEED_TOLERANCE
    assert -sent.velocity[2] <= ENVELOPE.climb_mps * SPEED_TOLERANCE
    assert sent.velocity[2] <= ENVELOPE.descent_mps * SPEED_TOLERANCE


@given(setpoint=SETPOINTS, state=STATES)
def test_a_hold_is_never_refused_for_where_the_vehicle_is_going(
    setpoint: Setpoint, state: VehicleState
) -> None:
    """What the gate puts in place of a setpoint passes it, unless the vehicle itself is outside."""
    found = verdict(setpoint, state)
    if found.setpoint is None or NOW_S - state.stamp_s > ENVELOPE.max_age_s:
        return
    again = verdict(found.setpoint, state)
    assert again.setpoint == found.setpoint
    assert again.refusal in (
        None,
        Refusal("outside the fence"),
        Refusal("outside the altitude band"),
    )
