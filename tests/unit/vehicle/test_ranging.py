"""OBSTACLE_DISTANCE from the wire to a scan in the mission's frame."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from autopilot import ENVELOPE, Meeting, in_offboard

from companion.mavlink.framing import MavlinkCodec, dialect
from companion.motion.position_error import EXACT_HEIGHT_M, GPS_HEIGHT_M
from companion.motion.range_scan import RangeScan
from companion.vehicle.range_below import DOWN, FRESH_S

SCANNER = MavlinkCodec(1, 196)
BODY, NORTH, UNKNOWN = dialect.MAV_FRAME_BODY_FRD, dialect.MAV_FRAME_GLOBAL, 65535


def obstacle_distance(
    distances_cm: list[int],
    time_s: float = 0.0,
    step_deg: float = 5.0,
    offset_deg: float = 0.0,
    frame: int = BODY,
    whole_step_deg: int = 0,
    range_cm: int = 1200,
) -> bytes:
    padded = [*distances_cm, *[UNKNOWN] * (72 - len(distances_cm))]
    message: Any = dialect.MAVLink_obstacle_distance_message(
        round(time_s * 1e6), 0, padded, whole_step_deg, 5, range_cm, step_deg, offset_deg, frame
    )
    return SCANNER.pack(message)


def heard(meeting: Meeting, *datagrams: bytes) -> RangeScan:
    meeting.tick(*datagrams)
    (scan,) = meeting.vehicle.scans
    return scan


def test_a_scan_that_turns_with_the_vehicle(meeting: Meeting) -> None:
    meeting.autopilot.home = [3.0, -4.0, 0.5]
    meeting.autopilot.position, meeting.autopilot.yaw_rad = [4.0, -2.0, 0.5], 0.3
    in_offboard(meeting)
    scan = heard(meeting, obstacle_distance([150, 1200, 1201, UNKNOWN, 0], offset_deg=90.0))
    assert scan.stamp_s == meeting.now_s
    assert scan.position == pytest.approx((1.0, 2.0))
    np.testing.assert_equal(scan.distances_m[:5], [1.5, 12.0, math.inf, math.nan, 0.0])
    assert len(scan.distances_m) == 72
    assert (scan.first_rad, scan.yaw_rad) == pytest.approx((math.pi / 2, 0.3))
    assert scan.step_rad == pytest.approx(math.radians(5))
    assert scan.range_m == 12.0
    meeting.tick()
    assert meeting.vehicle.scans == []


def test_a_scan_that_is_fixed_to_north_is_level(meeting: Meeting) -> None:
    meeting.tick()
    meeting.is_quiet = True
    meeting.tick(*at(10.0, 4.0, 0.3, meeting.autopilot.codec, (0.1, -0.2)))
    scan = heard(meeting, obstacle_distance([100] * 72, frame=NORTH))
    assert (scan.first_rad, scan.yaw_rad, scan.tilt_rad) == (0.0, 0.0, (0.0, 0.0))


@pytest.mark.parametrize(
    ("whole", "exact", "expected_deg", "beams"),
    [(10, 0.0, 10, 36), (10, 2.5, 2.5, 72), (5, -5.0, -5, 72), (90, 0.0, 90, 4)],
)
def test_the_exact_step_counts_and_no_beam_comes_twice(
    whole: int, exact: float, expected_deg: float, beams: int, meeting: Meeting
) -> None:
    scan = heard(meeting, obstacle_distance([100] * 72, step_deg=exact, whole_step_deg=whole))
    assert math.degrees(scan.step_rad) == pytest.approx(expected_deg)
    assert len(scan.distances_m) == beams


@pytest.mark.parametrize(
    "datagram",
    [
        obstacle_distance([100], frame=dialect.MAV_FRAME_LOCAL_NED),
        obstacle_distance([100], step_deg=0.0),
        obstacle_distance([100], step_deg=math.nan),
        obstacle_distance([100], step_deg=1e-30),
        obstacle_distance([100], step_deg=360.5),
        obstacle_distance([100], step_deg=-1e30),
        obstacle_distance([100], offset_deg=math.inf),
        obstacle_distance([100], range_cm=0),
    ],
)
def test_what_is_not_understood_is_no_scan(datagram: bytes, meeting: Meeting) -> None:
    meeting.tick(datagram)
    assert meeting.vehicle.scans == []


def test_only_the_scanner_of_the_vehicle_is_listened_to(meeting: Meeting) -> None:
    meeting.tick()
    body = dialect.MAVLink_obstacle_distance_message(0, 0, [100] * 72, 5, 5, 1200, 5.0, 0.0, BODY)
    for stranger in (MavlinkCodec(2, 196), MavlinkCodec(1, 25), MavlinkCodec(1, 1)):
        meeting.tick(stranger.pack(body))
        assert meeting.vehicle.scans == []


def test_no_scan_is_placed_before_the_place_is_known() -> None:
    meeting = Meeting(ENVELOPE)
    meeting.is_quiet = True
    meeting.tick(obstacle_distance([100] * 72))
    assert meeting.vehicle.scans == []


def at(
    time_s: float,
    north_m: float,
    yaw_rad: float,
    codec: MavlinkCodec,
    tilt_rad: tuple[float, float] = (0.0, 0.0),
    up_m: float = 2.0,
) -> list[bytes]:
    boot_ms = round(1000 * time_s)
    messages = (
        dialect.MAVLink_attitude_message(boot_ms, *tilt_rad, yaw_rad, 0, 0, 0),
        dialect.MAVLink_local_position_ned_message(boot_ms, north_m, 0, -up_m, 2, 0, 0),
    )
    return [codec.pack(message) for message in messages]


@pytest.mark.parametrize("measured_s", [10.0, 10.02, 10.05, 10.08])
def test_position_and_heading_are_those_of_the_time_of_the_scan(
    measured_s: float, meeting: Meeting
) -> None:
    """2 m/s, and a turn of 1 rad/s through south, where headings change their sign."""
    meeting.tick()
    meeting.is_quiet = True
    meeting.tick(*at(10.0, 4.0, math.pi - 0.02, meeting.autopilot.codec))
    scan = heard(
        meeting,
        obstacle_distance([100] * 72, time_s=measured_s),
        *at(10.05, 4.1, -math.pi + 0.03, meeting.autopilot.codec),
    )
    passed_s = measured_s - 10.0
    assert scan.position[0] == pytest.approx(4.0 + 2 * passed_s, abs=1e-5)
    turned_rad = math.remainder(scan.yaw_rad - (math.pi - 0.02 + passed_s), 2 * math.pi)
    assert turned_rad == pytest.approx(0.0, abs=1e-5)


def test_tilt_and_height_are_those_of_the_time_of_the_scan(meeting: Meeting) -> None:
    meeting.tick()
    meeting.is_quiet = True
    autopilot = meeting.autopilot.codec
    meeting.tick(*at(10.0, 4.0, 0.0, autopilot, (0.1, -0.2), 1.0))
    scan = heard(
        meeting,
        obstacle_distance([100] * 72, time_s=10.02),
        *at(10.05, 4.1, 0.0, autopilot, (0.2, 0.3), 2.0),
    )
    assert scan.tilt_rad == pytest.approx((0.14, 0.0), abs=1e-6)
    assert scan.up_m == pytest.approx(1.4)


def test_a_height_that_a_range_finder_confirms_is_taken_for_exact(meeting: Meeting) -> None:
    """By GPS 2 m may be 1 m; so long as what is below is 1.9 m away it is not."""
    codec = meeting.autopilot.codec
    meeting.tick()
    meeting.is_quiet = True
    meeting.tick(*at(10.0, 4.0, 0.0, codec))
    good_for_25_cm = dialect.MAVLink_estimator_status_message(0, 0, *[0.0] * 6, 0.25, 0.5)
    reads_190_cm = dialect.MAVLink_distance_sensor_message(0, 20, 1200, 190, 0, 0, DOWN, 0)
    gps, below = codec.pack(good_for_25_cm), codec.pack(reads_190_cm)

    def height_error_m(*datagrams: bytes) -> float:
        scan = obstacle_distance([100] * 72, time_s=10.0)
        return heard(meeting, scan, *datagrams).height_error_m

    assert height_error_m(gps) == GPS_HEIGHT_M
    assert height_error_m(below) == GPS_HEIGHT_M, "a single echo is none"
    assert height_error_m(below) == pytest.approx(0.1 + EXACT_HEIGHT_M)
    meeting.run(2 * FRESH_S)
    assert height_error_m() == GPS_HEIGHT_M


@pytest.mark.parametrize("tilt_rad", [(math.nan, 0.0), (0.0, math.inf)])
def test_an_attitude_that_is_not_known_places_no_scan(
    tilt_rad: tuple[float, float], meeting: Meeting
) -> None:
    """The last one that was known does."""
    meeting.tick()
    meeting.is_quiet = True
    autopilot = meeting.autopilot.codec
    meeting.tick(*at(10.0, 4.0, 0.1, autopilot, (0.1, 0.2)))
    scan = heard(
        meeting,
        *at(10.05, 4.1, 0.5, autopilot, tilt_rad),
        obstacle_distance([100] * 72, time_s=10.04),
    )
    assert (*scan.tilt_rad, scan.yaw_rad) == pytest.approx((0.1, 0.2, 0.1), abs=0.001)


@pytest.mark.parametrize(("roll_deg", "is_used"), [(55, True), (65, False), (180, False)])
def test_a_vehicle_that_has_fallen_over_sees_nothing(
    roll_deg: float, is_used: bool, meeting: Meeting
) -> None:
    meeting.tick()
    meeting.is_quiet = True
    autopilot = meeting.autopilot.codec
    tilt_rad = (math.radians(roll_deg), 0.0)
    meeting.tick(*at(10.0, 4.0, 0.1, autopilot), *at(10.05, 4.0, 0.1, autopilot, tilt_rad))
    meeting.tick(obstacle_distance([100] * 72, time_s=10.05))
    assert bool(meeting.vehicle.scans) is is_used


def test_a_scanner_with_a_clock_of_its_own_measured_at_the_last_position(meeting: Meeting) -> None:
    meeting.tick()
    meeting.is_quiet = True
    meeting.tick(*at(10.0, 4.0, 0.1, meeting.autopilot.codec))
    last = at(10.05, 4.1, 0.2, meeting.autopilot.codec)
    scan = heard(meeting, *last, obstacle_distance([100] * 72, time_s=1.7e9))
    assert scan.position[0] == pytest.approx(4.1) and scan.yaw_rad == pytest.approx(0.2)


def test_a_scan_that_has_overtaken_its_positions_waits_for_them(meeting: Meeting) -> None:
    meeting.tick()
    meeting.is_quiet = True
    autopilot = meeting.autopilot.codec
    meeting.tick(*at(10.0, 4.0, 0.1, autopilot), obstacle_distance([100] * 72, time_s=10.2))
    assert meeting.vehicle.scans == []
    meeting.tick(*at(10.1, 4.2, 0.2, autopilot))
    assert meeting.vehicle.scans == []
    scan = heard(meeting, *at(10.3, 4.6, 0.6, autopilot))
    assert scan.position[0] == pytest.approx(4.4) and scan.yaw_rad == pytest.approx(0.4)


def test_an_old_scan_is_placed_where_the_vehicle_was(meeting: Meeting) -> None:
    meeting.tick()
    meeting.is_quiet = True
    for time_s, north_m, yaw_rad in ((10.0, 4.0, 0.0), (10.1, 4.2, 0.0), (10.2, 4.3, 0.3)):
        meeting.tick(*at(time_s, north_m, yaw_rad, meeting.autopilot.codec))
    scan = heard(meeting, obstacle_distance([100] * 72, time_s=10.05))
    assert scan.position[0] == pytest.approx(4.1) and scan.yaw_rad == pytest.approx(0.0)
