"""Which origin is in force: that in which both positions of the autopilot agree."""

from __future__ import annotations

from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from companion.geometry import GlobalOrigin, Ned
from companion.mavlink.framing import dialect
from companion.vehicle.mission_frame import MissionFrame
from companion.vehicle.origin_watch import AGREES_M, APART_S, OriginWatch

FIRST = GlobalOrigin(47.3977, 8.5456, 488.0)
OTHER = GlobalOrigin(47.41, 8.53, 455.0)
HERE: Ned = (30.0, -20.0, -12.0)
STILL: Ned = (0.0, 0.0, 0.0)
metres = st.floats(-3000, 3000)


def told(origin: GlobalOrigin) -> Any:
    degrees = round(origin.latitude_deg * 1e7), round(origin.longitude_deg * 1e7)
    return dialect.MAVLink_gps_global_origin_message(*degrees, round(origin.altitude_m * 1e3), 0)


def on_earth(origin: GlobalOrigin, local: Ned, boot_s: float = 0.0) -> Any:
    latitude, longitude, altitude_m = origin.to_global(local)
    return dialect.MAVLink_global_position_int_message(
        round(boot_s * 1e3),
        *(round(latitude * 1e7), round(longitude * 1e7), round(altitude_m * 1e3)),
        *(0, 0, 0, 0, 0),
    )


def watch_of(origin: GlobalOrigin = FIRST, local: Ned = HERE) -> OriginWatch:
    """A watch that has heard all three."""
    watch = OriginWatch()
    watch.take_origin(told(origin))
    watch.take_local(0.0, local, STILL)
    watch.take_global(on_earth(origin, local))
    return watch


def test_an_origin_is_in_force_when_both_positions_agree_in_it() -> None:
    watch = OriginWatch()
    assert (watch.origin, watch.residual_m) == (None, None)
    watch.take_local(0.0, HERE, STILL)
    watch.take_global(on_earth(FIRST, HERE))
    assert (watch.origin, watch.is_doubted) == (None, False)
    watch.take_origin(told(FIRST))
    assert watch.origin == FIRST
    assert watch.residual_m is not None and watch.residual_m < 0.02  # 1e-7 degrees are 11 mm


@pytest.mark.parametrize("off", [(2.0, 0.0, 0.0), (0.0, -2.0, 0.0), (0.0, 0.0, 2.0)])
def test_an_origin_in_which_they_disagree_never_is(off: Ned) -> None:
    watch = OriginWatch()
    watch.take_origin(told(FIRST))
    watch.take_local(0.0, HERE, STILL)
    watch.take_global(on_earth(FIRST, (HERE[0] + off[0], HERE[1] + off[1], HERE[2] + off[2])))
    assert watch.origin is None and watch.residual_m == pytest.approx(2.0, abs=0.02)


def test_a_jump_before_the_message_is_doubted_until_the_message_explains_it() -> None:
    watch = watch_of()
    there = OTHER.to_local(*FIRST.to_global(HERE))
    watch.take_local(0.1, there, STILL)
    assert watch.is_doubted and watch.origin == FIRST
    watch.take_origin(told(OTHER))
    assert not watch.is_doubted and watch.origin == OTHER


def test_a_message_before_the_jump_waits_for_it() -> None:
    watch = watch_of()
    watch.take_origin(told(OTHER))
    assert not watch.is_doubted and watch.origin == FIRST
    watch.take_local(0.1, OTHER.to_local(*FIRST.to_global(HERE)), STILL)
    assert not watch.is_doubted and watch.origin == OTHER


def test_a_false_origin_displaces_nothing() -> None:
    watch = watch_of()
    watch.take_origin(told(OTHER))
    for tick in range(1, 50):
        watch.take_local(0.05 * tick, HERE, STILL)
        watch.take_global(on_earth(FIRST, HERE, 0.05 * tick))
        assert not watch.is_doubted and watch.origin == FIRST


def test_an_estimate_that_is_corrected_is_no_other_frame() -> None:
    watch = watch_of()
    corrected = (HERE[0] + 5.0, HERE[1], HERE[2])
    watch.take_local(0.1, corrected, STILL)
    assert watch.is_doubted  # for the time between two messages
    watch.take_global(on_earth(FIRST, corrected, 0.1))
    assert not watch.is_doubted and watch.origin == FIRST


def test_positions_of_two_times_are_compared_by_the_velocity_or_not_at_all() -> None:
    watch = watch_of()
    watch.take_local(1.0, HERE, (20.0, 0.0, 0.0))
    watch.take_global(on_earth(FIRST, (HERE[0] + 3.0, HERE[1], HERE[2]), 1.15))
    assert not watch.is_doubted and watch.residual_m == pytest.approx(0.0, abs=0.02)
    watch.take_global(on_earth(FIRST, (HERE[0] + 300.0, HERE[1], HERE[2]), 1.1 + APART_S))
    assert not watch.is_doubted


def frame_in(origin: GlobalOrigin, anchor: GlobalOrigin | None = None) -> MissionFrame:
    frame = MissionFrame()
    frame.anchor_at(anchor)
    frame.take_home((4.0, 7.0, 1.0), origin.altitude_m - 1.0)
    frame.take_reference(origin)
    return frame


@given(metres, metres, st.floats(-100, 0))
def test_a_mission_frame_stays_on_the_earth_when_the_origin_moves(
    north: float, east: float, down: float
) -> None:
    """A frame in metres but for the turn between two norths, 0.02 degrees here."""
    local = (north, east, down)
    there = OTHER.to_local(*FIRST.to_global(local))
    for anchor, off_m in ((GlobalOrigin(47.39, 8.54, 0.0), 0.001), (None, AGREES_M + 0.5)):
        frame = frame_in(FIRST, anchor)
        before = frame.position(local)
        frame.take_reference(OTHER)
        assert frame.position(there) == pytest.approx(before, abs=off_m)
        assert frame.local(frame.position(there)) == pytest.approx(there, abs=0.001)


def test_an_anchored_frame_begins_where_its_file_says_at_the_height_of_the_ground() -> None:
    anchor = GlobalOrigin(47.39, 8.54, 0.0)
    frame = frame_in(FIRST, anchor)
    standing = FIRST.to_local(47.39, 8.54, 491.0)
    for tick in range(300):
        frame.take_position(0.05 * tick, standing, is_standing=True)
    assert frame.gap_m((0.0, 0.0, -5.0), 0.05) == pytest.approx(0.0, abs=0.01)
    frame.lay((0.0, 0.0, -5.0))
    assert frame.altitude_m == pytest.approx(491.0)
    assert frame.position(standing) == pytest.approx((0.0, 0.0, 0.0), abs=0.001)
    assert frame.zero is not None
    assert (frame.zero.latitude_deg, frame.zero.longitude_deg) == pytest.approx((47.39, 8.54))


def test_an_anchored_frame_is_not_known_before_the_origin_is() -> None:
    frame = MissionFrame()
    frame.anchor_at(FIRST)
    frame.take_home((0.0, 0.0, 0.0), 488.0)
    assert not frame.is_known and frame.origin is None and frame.zero is None
    frame.take_reference(FIRST)
    assert frame.is_known


def test_a_mission_in_metres_after_one_in_degrees_is_laid_where_the_vehicle_stands() -> None:
    frame = frame_in(FIRST, GlobalOrigin(47.39, 8.54, 0.0))
    standing = (6.0, 7.5, 0.0)
    for tick in range(300):
        frame.take_position(0.05 * tick, standing, is_standing=True)
    frame.lay((0.0, 0.0, -5.0))
    frame.move((0.3, 0.0), 0.5)
    frame.anchor_at(None)
    frame.lay((0.0, 0.0, -5.0))
    assert frame.origin == standing
