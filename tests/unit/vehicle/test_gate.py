"""The last line before the wire: each rule has a test that fails without it.

Limits are met exactly, in numbers that are exact in binary: an interval that is shifted, or an end
that is taken for the other side, fails.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import pytest
from at_the_gate import AFTER, ENVELOPE, GOOD, HOLD, NOW_S, STATE, heard, verdict
from hypothesis import given
from hypothesis import strategies as st

from companion.geometry import Ned, distance, is_in_polygon
from companion.outcomes import Refusal
from companion.vehicle.gate import (
    EXTRAPOLATED_S,
    SPEED_TOLERANCE,
    Envelope,
    Request,
    Verdict,
    admit,
)
from companion.vehicle.ports.setpoints import Setpoint, hold_at
from companion.vehicle.ports.state import Mode, VehicleState

NOT_FINITE = [math.nan, math.inf, -math.inf]


def changed(vector: Ned, axis: int, number: float) -> Ned:
    north, east, down = (number if i == axis else old for i, old in enumerate(vector))
    return (north, east, down)


def held(refusal: str) -> Verdict:
    return Verdict(HOLD, Refusal(refusal))


def nothing(refusal: str) -> Verdict:
    return Verdict(None, Refusal(refusal))


def test_a_good_setpoint_passes_as_it_is() -> None:
    assert verdict() == Verdict(GOOD)


def test_the_limits_that_no_mission_chooses() -> None:
    """Half a second is ten setpoints; PX4's failsafe begins a second after the last one."""
    made = Envelope(ENVELOPE.fence, (0.5, 4.0), 2.0, 1.5, 1.0, 1.5)
    ages_s = (made.max_age_s, made.lease_s, made.lost_s, made.mode_lost_s)
    assert ages_s == (0.5, 0.5, 3.0, 10.0)
    assert made.fence_margin_m == 0.0
    assert (SPEED_TOLERANCE, EXTRAPOLATED_S) == (1.01, 0.2)


# -- nothing is sent -------------------------------------------------------------------------------


def test_without_a_position_nothing_is_sent() -> None:
    assert verdict(state=None) == nothing("the position is unknown")


@pytest.mark.parametrize("axis", range(3))
@pytest.mark.parametrize("number", NOT_FINITE)
def test_a_position_that_is_not_finite_is_unknown(axis: int, number: float) -> None:
    state = heard(position=changed(STATE.motion.position, axis, number))
    assert verdict(state=state) == nothing("the position is unknown")


@pytest.mark.parametrize("number", NOT_FINITE)
def test_a_heading_that_is_not_finite_is_unknown(number: float) -> None:
    assert verdict(state=heard(yaw_rad=number)) == nothing("the position is unknown")


def test_when_the_position_was_lost_nothing_is_sent() -> None:
    """Only silence lets the autopilot's own failsafe begin."""
    assert verdict(state=heard(motion_measured_s=NOW_S - 3.0)) == held("the position is 3.0 s old")
    assert verdict(state=heard(motion_measured_s=NOW_S - 3.0 - AFTER)) == nothing(
        "no position for 3.0 s"
    )
    assert verdict(state=heard(motion_measured_s=math.nan)) == nothing("no position for nan s")


def test_when_the_mode_was_lost_nothing_is_sent() -> None:
    assert verdict(state=heard(heartbeat_received_s=NOW_S - 10.0)) == Verdict(GOOD)
    assert verdict(state=heard(heartbeat_received_s=NOW_S - 10.0 - AFTER)) == nothing(
        "no mode for 10.0 s"
    )
    assert verdict(state=heard(heartbeat_received_s=math.nan)) == nothing("no mode for nan s")


def test_a_vehicle_that_is_not_armed_is_sent_nothing() -> None:
    assert verdict(state=heard(is_armed=False)) == nothing("the vehicle is not armed")


@pytest.mark.parametrize("mode", [mode for mode in Mode if mode is not Mode.OFFBOARD])
def test_another_mode_takes_setpoints_only_before_offboard_is_asked_for(mode: Mode) -> None:
    state = heard(mode=mode)
    assert verdict(state=state) == nothing(f"the mode is {mode.value}")
    assert verdict(state=state, is_entering=True) == Verdict(GOOD)


# -- hold ------------------------------------------------------------------------------------------


def test_old_telemetry_holds() -> None:
    assert verdict(
        state=heard(motion_measured_s=NOW_S - 0.5, attitude_measured_s=NOW_S - 0.5)
    ) == Verdict(GOOD)
    assert verdict(state=heard(motion_measured_s=NOW_S - 0.5 - AFTER)) == held(
        "the position is 0.5 s old"
    )
    assert verdict(state=heard(attitude_measured_s=NOW_S - 0.5 - AFTER)) == held(
        "the heading is 0.5 s old"
    )
    assert verdict(state=heard(attitude_measured_s=-math.inf)) == held("the heading is inf s old")
    assert verdict(state=heard(attitude_measured_s=math.nan)) == held("the heading is nan s old")


def test_a_position_that_is_being_lost_holds() -> None:
    """By whatever plan, and however bad one is that stays as it is."""
    for is_for_task in (False, True):
        lost = verdict(state=heard(is_drifting=True, accuracy_m=0.75), is_for_task=is_for_task)
        assert lost == held("the position is good for 0.8 m, and gets worse")
        assert verdict(state=heard(accuracy_m=5.0), is_for_task=is_for_task) == Verdict(GOOD)


def test_a_setpoint_that_nobody_renews_holds() -> None:
    assert verdict(asked_s=NOW_S - 0.5) == Verdict(GOOD)
    assert verdict(asked_s=NOW_S - 0.5 - AFTER) == held("not renewed for 0.5 s")
    assert verdict(asked_s=math.nan) == held("not renewed for nan s")


@pytest.mark.parametrize(
    ("is_for_task", "is_violated", "passes"),
    [(False, False, True), (True, False, True), (False, True, True), (True, True, False)],
)
def test_a_plan_for_a_task_that_is_violated_holds(
    is_for_task: bool, is_violated: bool, passes: bool
) -> None:
    """A return, a landing and a hold go on."""
    found = verdict(is_for_task=is_for_task, is_violated=is_violated)
    assert found == (Verdict(GOOD) if passes else held("the task is violated"))


BEGUN = hold_at((4.0, 15.0, -2.25), 0.25)
HELD = Verdict(BEGUN, Refusal("outside the fence"))
OUTSIDE = replace(GOOD, position=(5.5, 21.0, -2.25))


@pytest.mark.parametrize(
    ("before", "is_kept"),
    [(HELD, True), (None, False), (Verdict(BEGUN), False), (Verdict(None, HELD.refusal), False)],
)
def test_a_hold_stays_where_it_began(before: Verdict | None, is_kept: bool) -> None:
    """And not where an estimate has drifted to by then; not where a setpoint was that passed."""
    told = admit(Request(OUTSIDE, NOW_S), STATE, NOW_S, ENVELOPE, before=before)
    assert told == Verdict(BEGUN if is_kept else HOLD, Refusal("outside the fence"))


@pytest.mark.parametrize(("away_m", "is_kept"), [(1.5, True), (1.5 + AFTER, False)])
def test_a_hold_begins_anew_beyond_the_carrot(away_m: float, is_kept: bool) -> None:
    state = heard(position=changed(STATE.motion.position, 0, 4.0 + away_m))
    told = admit(Request(OUTSIDE, NOW_S), state, NOW_S, ENVELOPE, before=HELD).setpoint
    assert told == (BEGUN if is_kept else hold_at(state.motion.position, state.attitude.yaw_rad))


def test_a_hold_in_a_frame_in_doubt_does_not_stay() -> None:
    doubt = Refusal("the frame has moved")
    request = Request(GOOD, NOW_S)
    told = admit(request, STATE, NOW_S, ENVELOPE, frame_doubt=doubt, before=HELD)
    assert told == Verdict(HOLD, doubt)


def test_what_passes_again_is_sent() -> None:
    assert admit(Request(GOOD, NOW_S), STATE, NOW_S, ENVELOPE, before=HELD) == Verdict(GOOD)


def test_a_frame_in_doubt_holds_where_the_vehicle_is() -> None:
    """Whatever is asked for, and also what asks for OFFBOARD; what is not sent stays so."""
    doubt, asked = Refusal("two positions"), Request(GOOD, NOW_S)
    for state in (STATE, heard(mode=Mode.LOITER)):
        found = admit(asked, state, NOW_S, ENVELOPE, is_entering=True, frame_doubt=doubt)
        assert found == held("two positions")
    lost = admit(asked, heard(is_armed=False), NOW_S, ENVELOPE, frame_doubt=doubt)
    assert lost == nothing("the vehicle is not armed")


def test_nothing_is_of_the_task_or_violated_unless_that_is_said() -> None:
    asked = Request(GOOD, NOW_S)
    assert admit(asked, STATE, NOW_S, ENVELOPE, is_violated=True) == Verdict(GOOD)
    assert admit(replace(asked, is_for_task=True), STATE, NOW_S, ENVELOPE) == Verdict(GOOD)


def test_of_two_that_are_old_the_position_is_told() -> None:
    state = heard(motion_measured_s=NOW_S - 1.0, attitude_measured_s=NOW_S - 2.0)
    assert verdict(state=state) == held("the position is 1.0 s old")


@pytest.mark.parametrize("field", ["position", "velocity", "acceleration"])
@pytest.mark.parametrize("axis", range(3))
@pytest.mark.parametrize("number", NOT_FINITE)
def test_a_number_that_is_not_finite_holds(field: str, axis: int, number: float) -> None:
    spoilt: dict[str, Any] = {field: changed(getattr(GOOD, field), axis, number)}
    assert verdict(replace(GOOD, **spoilt)) == held("the setpoint is not finite")


@pytest.mark.parametrize("number", NOT_FINITE)
def test_a_heading_to_turn_to_that_is_not_finite_holds(number: float) -> None:
    assert verdict(replace(GOOD, yaw_rad=number)) == held("the setpoint is not finite")


@pytest.mark.parametrize(
    ("edge", "outwards"),
    [
        ((0.25, 5.0), (-1, 0)),
        ((9.75, 5.0), (1, 0)),
        ((5.0, -19.75), (0, -1)),
        ((5.0, 19.75), (0, 1)),
    ],
)
def test_each_side_of_the_fence_holds(edge: tuple[float, float], outwards: tuple[int, int]) -> None:
    """At the margin and just beyond it; far beyond the fence the margin says nothing."""
    state = heard(position=(*edge, -2.0))
    at_the_margin = replace(GOOD, position=(*edge, -2.0))
    assert verdict(at_the_margin, state) == Verdict(at_the_margin)
    expected = Verdict(
        hold_at(state.motion.position, state.attitude.yaw_rad), Refusal("outside the fence")
    )
    for beyond_m in (AFTER, 1.0):
        north, east = (e + beyond_m * o for e, o in zip(edge, outwards, strict=True))
        assert verdict(replace(GOOD, position=(north, east, -2.0)), state) == expected


def test_the_fence_is_no_wider_without_a_margin() -> None:
    envelope = replace(ENVELOPE, fence_margin_m=0.0)
    for north, is_inside in ((AFTER, True), (-AFTER, False), (10 - AFTER, True), (10.25, False)):
        state = heard(position=(min(max(north, 0.5), 9.5), 5.0, -2.0))
        setpoint = replace(GOOD, position=(north, 5.0, -2.0))
        assert (verdict(setpoint, state, envelope).refusal is None) is is_inside


@pytest.mark.parametrize(
    ("up_m", "is_within"),
    [(0.5 - AFTER, False), (0.5, True), (4.0, True), (4.0 + AFTER, False)],
)
def test_the_altitude_band_has_two_ends(up_m: float, is_within: bool) -> None:
    state = heard(position=(5.0, 5.0, -min(max(up_m, 1.0), 3.5)))
    setpoint = replace(GOOD, position=(5.0, 5.0, -up_m))
    found = verdict(setpoint, state)
    assert (found.setpoint == setpoint) is is_within
    assert found.refusal == (None if is_within else Refusal("outside the altitude band"))


@pytest.mark.parametrize(("up_m", "is_within"), [(4.5, True), (4.25, True), (4.5 + AFTER, False)])
def test_a_vehicle_above_the_band_is_sent_no_higher(up_m: float, is_within: bool) -> None:
    state = heard(position=(5.0, 5.0, -4.5))
    found = verdict(replace(GOOD, position=(5.0, 5.0, -up_m)), state)
    assert found.refusal == (None if is_within else Refusal("outside the altitude band"))


JUST_NOW = heard(motion_measured_s=NOW_S)


@pytest.mark.parametrize("axis", range(3))
@pytest.mark.parametrize("sign", [-1, 1])
def test_the_carrot_reaches_equally_far_in_every_direction(axis: int, sign: int) -> None:
    def beside(gap_m: float) -> Setpoint:
        along = STATE.motion.position[axis] + sign * gap_m
        return replace(GOOD, position=changed(STATE.motion.position, axis, along))

    assert verdict(beside(1.5), JUST_NOW).refusal is None
    assert verdict(beside(1.625), JUST_NOW) == held("1.6 m from the vehicle")


def test_the_carrot_is_a_ball_and_not_a_box() -> None:
    corner = replace(GOOD, position=(6.0, 16.0, -3.25))
    assert verdict(corner, JUST_NOW) == held("1.7 m from the vehicle")


@pytest.mark.parametrize(
    ("velocity", "age_s", "flown_m"),
    [
        ((2.0, 0.0, 0.0), 0.125, 0.25),
        ((-2.0, 0.0, 0.0), 0.125, -0.25),
        ((0.0, 2.0, 0.0), 0.125, 0.0),
        ((2.0, 0.0, 0.0), 0.5, 2 * EXTRAPOLATED_S),
        ((8.0, 0.0, 0.0), 0.125, 0.25),
        ((2.0, 0.0, 0.0), -0.125, 0.0),
    ],
    ids=["on", "back", "aside", "old", "faster than allowed", "clock ahead"],
)
def test_the_carrot_begins_where_the_vehicle_is_by_now(
    velocity: Ned, age_s: float, flown_m: float
) -> None:
    """Where it was measured it is no longer; but no old position lets a setpoint run ahead."""
    state = heard(motion_measured_s=NOW_S - age_s, velocity=velocity)
    here = (5.0 + flown_m, 15.0 + (0.25 if velocity[1] else 0.0), -2.25)

    def along(gap_m: float) -> Setpoint:
        return replace(GOOD, position=(here[0] + gap_m, here[1], here[2]))

    for sign in (-1, 1):
        assert verdict(along(sign * 1.499), state).refusal is None
        assert verdict(along(sign * 1.501), state) == held("1.5 m from the vehicle")


@pytest.mark.parametrize("number", NOT_FINITE)
def test_a_velocity_that_is_not_finite_holds(number: float) -> None:
    assert verdict(GOOD, heard(velocity=(number, 0.0, 0.0))).refusal is not None


@pytest.mark.parametrize("velocity", [(0.0, 0.0, -2.1), (1.5, -1.5, 0.0), (-2.1, 0.0, 0.0)])
def test_more_than_the_speed_limit_holds(velocity: Ned) -> None:
    assert verdict(replace(GOOD, velocity=velocity)) == held("2.1 m/s is too fast")


@pytest.mark.parametrize(
    ("down_mps", "refusal"),
    [
        (-1.5 * SPEED_TOLERANCE, None),
        (-1.6, "1.6 m/s up is too fast"),
        (1.0 * SPEED_TOLERANCE, None),
        (1.1, "1.1 m/s down is too fast"),
    ],
)
def test_climbs_and_descents_have_limits_of_their_own(down_mps: float, refusal: str | None) -> None:
    setpoint = replace(GOOD, velocity=(0.1, 0.0, down_mps))
    assert verdict(setpoint) == (held(refusal) if refusal else Verdict(setpoint))


def test_a_vehicle_that_cannot_climb_may_fly_level() -> None:
    envelope = replace(ENVELOPE, climb_mps=0.0)
    assert verdict(envelope=envelope) == Verdict(GOOD)
    descending = replace(GOOD, velocity=(0.0, 0.0, 0.5))
    assert verdict(descending, envelope=envelope) == Verdict(descending)


def test_rounding_at_the_limit_does_not_stop_the_vehicle() -> None:
    fastest = replace(GOOD, velocity=(ENVELOPE.speed_mps * SPEED_TOLERANCE, 0.0, 0.0))
    assert verdict(fastest).refusal is None
    faster = replace(GOOD, velocity=(ENVELOPE.speed_mps * SPEED_TOLERANCE + AFTER, 0.0, 0.0))
    assert verdict(faster) == held("2.0 m/s is too fast")


# -- whatever comes --------------------------------------------------------------------------------

ANY = st.floats() | st.floats(-12, 12)
VECTOR = st.tuples(ANY, ANY, ANY)
NEAR = st.tuples(st.floats(-1, 11), st.floats(-21, 21), st.floats(-5, 1))
SETPOINTS = st.builds(Setpoint, NEAR | VECTOR, VECTOR, VECTOR, ANY)
STATES = st.builds(
    heard,
    motion_measured_s=st.floats(NOW_S - 5, NOW_S),
    attitude_measured_s=st.floats(NOW_S - 1, NOW_S),
    position=NEAR | VECTOR,
    yaw_rad=st.floats(-math.pi, math.pi),
    mode=st.sampled_from(Mode),
)


@given(setpoint=SETPOINTS, state=st.none() | STATES, is_entering=st.booleans())
def test_what_comes_out_is_within_all_limits_or_exactly_the_hold(
    setpoint: Setpoint, state: VehicleState | None, is_entering: bool
) -> None:
    found = verdict(setpoint, state, is_entering=is_entering)
    if found.setpoint is None:
        assert found.refusal
        return
    assert state is not None and (is_entering or state.heartbeat.mode is Mode.OFFBOARD)
    sent = found.setpoint
    numbers = (*sent.position, *sent.velocity, *sent.acceleration, sent.yaw_rad)
    assert all(map(math.isfinite, numbers))
    if found.refusal:
        assert sent == hold_at(state.motion.position, state.attitude.yaw_rad)
        return
    assert sent == setpoint
    assert NOW_S - min(state.motion.measured_s, state.attitude.measured_s) <= ENVELOPE.max_age_s
    assert is_in_polygon(sent.position, ENVELOPE.fence)
    assert ENVELOPE.up_m[0] <= -sent.position[2] <= ENVELOPE.up_m[1]
    assert distance(sent.position, state.motion.position) <= ENVELOPE.carrot_m
    assert math.hypot(*sent.velocity) <= ENVELOPE.speed_mps * SPEED_TOLERANCE
    assert -sent.velocity[2] <= ENVELOPE.climb_mps * SPEED_TOLERANCE
    assert sent.velocity[2] <= ENVELOPE.descent_mps * SPEED_TOLERANCE


@given(setpoint=SETPOINTS, state=STATES)
def test_a_hold_is_never_refused_for_where_the_vehicle_is_going(
    setpoint: Setpoint, state: VehicleState
) -> None:
    """What the gate puts in place of a setpoint passes it, unless the vehicle itself is outside."""
    found = verdict(setpoint, state)
    measured_s = min(state.motion.measured_s, state.attitude.measured_s)
    if found.setpoint is None or NOW_S - measured_s > ENVELOPE.max_age_s:
        return
    again = verdict(found.setpoint, state)
    assert again.setpoint == found.setpoint
    assert again.refusal in (
        None,
        Refusal("outside the fence"),
        Refusal("outside the altitude band"),
    )


# -- the fence, against another rule ---------------------------------------------------------------

METRES = st.floats(-20, 20).map(lambda metres: round(metres * 8) / 8)
POINTS = st.tuples(METRES, METRES)


def turns(a: tuple[float, float], b: tuple[float, float], c: tuple[float, float]) -> float:
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])


@given(a=POINTS, b=POINTS, c=POINTS, point=POINTS)
def test_a_triangle_holds_what_lies_on_the_same_side_of_all_its_edges(
    a: tuple[float, float],
    b: tuple[float, float],
    c: tuple[float, float],
    point: tuple[float, float],
) -> None:
    envelope = replace(ENVELOPE, fence=(a, b, c), fence_margin_m=0.0)
    signs = [turns(a, b, point), turns(b, c, point), turns(c, a, point)]
    if 0.0 in signs:
        return  # on an edge
    is_inside = min(signs) > 0 or max(signs) < 0
    found = verdict(
        replace(GOOD, position=(*point, -2.0)), heard(position=(*point, -2.0)), envelope
    )
    assert (found.refusal is None) is is_inside


@given(point=st.tuples(st.floats(-9, 9), st.floats(-9, 9)))
def test_the_margin_of_a_slanted_fence_is_measured_across_its_edges(
    point: tuple[float, float],
) -> None:
    """A square on its corner: the distance from an edge follows from the sum of the two metres."""
    fence = ((8.0, 0.0), (0.0, 8.0), (-8.0, 0.0), (0.0, -8.0), (0.0, -8.0))
    gap_m = (8.0 - abs(point[0]) - abs(point[1])) / math.sqrt(2)
    if abs(gap_m - 1.0) < 1e-9:
        return
    envelope = replace(ENVELOPE, fence=fence, fence_margin_m=1.0)
    found = verdict(
        replace(GOOD, position=(*point, -2.0)), heard(position=(*point, -2.0)), envelope
    )
    assert (found.refusal is None) is (gap_m > 1.0)


@given(point=st.tuples(st.floats(-3, 3), st.floats(-3, 3)))
def test_beyond_the_end_of_an_edge_the_margin_is_round(point: tuple[float, float]) -> None:
    """A notch of the fence ends at (0, 0), in the middle of the room."""
    notched = ((9.0, -9.0), (9.0, 9.0), (-9.0, 9.0), (-9.0, 0.5), (0.0, 0.0), (-9.0, -0.5))
    fence = (*notched, (-9.0, -9.0))
    north, east = point
    if north < abs(east) * 0.5 / 9.0 or abs(math.hypot(*point) - 2.0) < 1e-9:
        return  # beside the notch, whose sides are not parallel
    envelope = replace(ENVELOPE, fence=fence, fence_margin_m=2.0)
    found = verdict(
        replace(GOOD, position=(*point, -2.0)), heard(position=(*point, -2.0)), envelope
    )
    assert (found.refusal is None) is (math.hypot(*point) > 2.0)
