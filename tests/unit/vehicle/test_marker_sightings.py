"""LANDING_TARGET in each form that is understood, and what is refused with words."""

from __future__ import annotations

import math
from typing import Any

import pytest

from companion.mavlink.framing import MavlinkCodec, dialect
from companion.outcomes import Refusal
from companion.vehicle.marker_sightings import APART_S, FAR_M, MOST, OLD_S, MarkerSightings
from companion.vehicle.ports.markers import MarkerSighting
from companion.vehicle.pose_messages import keep_pose
from companion.vehicle.poses import PoseHistory
from companion.vehicle.services import Moment
from companion.vehicle.telemetry import Telemetry

CAMERA, BOOT_S, NOW_S = 40, 100.0, 7.0
HOME = (10.0, 20.0, 0.5)
"""In the autopilot's local frame."""
LOCAL = (11.0, 22.0, -4.5)
"""Where the vehicle is there: 1 m north, 2 m east, 5 m above home."""
YAW = math.pi / 2
MARKER = (2.0, 4.0, -3.0)
"""In the mission's frame: 1 m north, 2 m east and 2 m below the vehicle."""


def arrived(message: Any, component: int) -> Any:
    (parsed,) = MavlinkCodec(0, 0).parse(MavlinkCodec(1, component).pack(message))
    return parsed


def target(**fields: Any) -> Any:
    about = {
        "time_usec": round(BOOT_S * 1e6),
        "target_num": 3,
        "frame": dialect.MAV_FRAME_LOCAL_NED,
        "angle_x": 0.0,
        "angle_y": 0.0,
        "distance": 0.0,
        "size_x": 0.0,
        "size_y": 0.0,
        "x": 12.0,
        "y": 24.0,
        "z": -2.5,
        "position_valid": 1,
    }
    return dialect.MAVLink_landing_target_message(**(about | fields))


class Vehicle:
    """A vehicle whose pose is known, with a camera."""

    def __init__(self, roll: float = 0.0, pitch: float = 0.0) -> None:
        self.telemetry = Telemetry()
        self.telemetry.frame.take_home(HOME, 400.0)
        self.poses = PoseHistory()
        self.markers = MarkerSightings(self.telemetry, {CAMERA}, self.poses)
        for boot_s in (BOOT_S - 0.1, BOOT_S):
            boot_ms = round(boot_s * 1e3)
            at = dialect.MAVLink_local_position_ned_message(boot_ms, *LOCAL, 0.0, 0.0, 0.0)
            turned = dialect.MAVLink_attitude_message(boot_ms, roll, pitch, YAW, 0.0, 0.0, 0.0)
            for message in (at, turned):
                keep_pose(self.poses, message, self.telemetry)

    def take(self, message: Any, component: int = CAMERA) -> None:
        self.markers.take(Moment(NOW_S, NOW_S, False), arrived(message, component))

    def sees(self, message: Any, component: int = CAMERA) -> MarkerSighting:
        self.take(message, component)
        assert not self.markers.refused
        (seen,) = self.markers.seen
        return seen

    def refuses(self, message: Any, component: int = CAMERA) -> str:
        self.take(message, component)
        assert not self.markers.seen
        (refusal,) = self.markers.refused
        assert isinstance(refusal, Refusal)
        return refusal.reason


def test_a_position_in_the_local_frame_is_one_in_the_missions() -> None:
    seen = Vehicle().sees(target())
    assert seen.position == pytest.approx(MARKER)
    assert seen == MarkerSighting(NOW_S, CAMERA, 3, seen.position)


@pytest.mark.parametrize("frame", [dialect.MAV_FRAME_BODY_FRD, dialect.MAV_FRAME_LOCAL_FRD])
def test_a_position_beside_the_vehicle_is_turned_by_its_heading(frame: int) -> None:
    """It looks east: 2 m ahead is east, 1 m to the left is north."""
    seen = Vehicle().sees(target(frame=frame, x=2.0, y=-1.0, z=2.0))
    assert seen.position == pytest.approx(MARKER)


def test_along_the_bodys_axes_tilt_counts_and_level_it_does_not() -> None:
    """Nose down by 30 degrees: what is straight ahead is lower, and no longer level."""
    tilted = Vehicle(pitch=-math.pi / 6)
    body = tilted.sees(target(frame=dialect.MAV_FRAME_BODY_FRD, x=2.0, y=0.0, z=0.0)).position
    assert body == pytest.approx((1.0, 2.0 + math.sqrt(3), -4.0))
    level = Vehicle(pitch=-math.pi / 6).sees(
        target(frame=dialect.MAV_FRAME_LOCAL_FRD, x=2.0, y=0.0, z=0.0)
    )
    assert level.position == pytest.approx((1.0, 4.0, -5.0))


def test_angles_with_a_distance_are_a_ray() -> None:
    """2 m ahead, 1 m to the left and 2 m down, as an image has it."""
    angles = {"angle_x": math.atan2(-1.0, 2.0), "angle_y": math.atan2(-2.0, 2.0), "distance": 3.0}
    seen = Vehicle().sees(target(position_valid=0, **angles))
    assert seen.position == pytest.approx(MARKER)


def test_a_sighting_is_placed_where_the_vehicle_was_then() -> None:
    vehicle = Vehicle()
    later = round((BOOT_S + 0.2) * 1e3)
    moved = dialect.MAVLink_local_position_ned_message(later, 13.0, *LOCAL[1:], 0.0, 0.0, 0.0)
    keep_pose(vehicle.poses, moved, vehicle.telemetry)
    seen = vehicle.sees(
        target(
            time_usec=round((BOOT_S + 0.1) * 1e6), frame=dialect.MAV_FRAME_LOCAL_FRD, x=2, y=-1, z=2
        )
    )
    assert seen.position == pytest.approx((3.0, 4.0, -3.0))
    assert seen.seen_s == pytest.approx(NOW_S - 0.1)


@pytest.mark.parametrize(
    ("fields", "why"),
    [
        ({"frame": dialect.MAV_FRAME_LOCAL_OFFSET_NED}, "its frame is 7"),
        ({"frame": dialect.MAV_FRAME_GLOBAL}, "its frame is 0"),
        ({"position_valid": 0}, "angles and no distance"),
        ({"position_valid": 0, "distance": math.nan}, "not finite"),
        ({"x": math.inf}, "not finite"),
        ({"x": 12.0 + FAR_M}, "m away"),
        ({"time_usec": round((BOOT_S - OLD_S - 0.1) * 1e6)}, "it is 0.6 s old"),
    ],
)
def test_what_is_not_understood_is_refused_with_words(fields: dict[str, Any], why: str) -> None:
    assert why in Vehicle().refuses(target(**fields))


@pytest.mark.parametrize("component", [1, 41, 191])
def test_a_component_that_the_mission_does_not_name_is_not_believed(component: int) -> None:
    assert f"component {component} is not one" in Vehicle().refuses(target(), component)


@pytest.mark.parametrize(
    "time_usec", [0, 1_700_000_000_000_000, round((BOOT_S + APART_S + 1) * 1e6)]
)
def test_a_stamp_of_another_clock_is_taken_for_now(time_usec: int) -> None:
    assert Vehicle().sees(target(time_usec=time_usec)).seen_s == NOW_S


def test_without_a_pose_nothing_is_placed() -> None:
    vehicle = Vehicle.__new__(Vehicle)
    vehicle.telemetry = Telemetry()
    vehicle.markers = MarkerSightings(vehicle.telemetry, {CAMERA}, PoseHistory())
    assert "own position is not known" in vehicle.refuses(target())


def test_a_flood_is_looked_at_in_part_and_forgotten_in_the_next_tick() -> None:
    vehicle = Vehicle()
    for _ in range(3 * MOST):
        vehicle.take(target())
    assert len(vehicle.markers.seen) == MOST
    vehicle.markers.step(Moment(NOW_S, NOW_S, False))
    assert (vehicle.markers.seen, vehicle.markers.refused) == ([], [])
    assert vehicle.markers.due(Moment(NOW_S, NOW_S, False)) == []
