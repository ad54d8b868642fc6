"""Where the vehicle was between two messages, and before and after all that are kept."""

from __future__ import annotations

import math
from typing import Any

import pytest

from companion.geometry import GlobalOrigin
from companion.mavlink.framing import dialect
from companion.vehicle.pose_messages import keep_pose
from companion.vehicle.poses import KEPT_S, Pose, PoseHistory
from companion.vehicle.telemetry import Telemetry


def pose_at(time_s: float) -> Pose:
    """It flies north at 2 m/s, and turns to the right at 1 rad/s through south at 10 s."""
    yaw_rad = math.remainder(math.pi + time_s - 10.0, 2 * math.pi)
    return Pose((2.0 * time_s, 0.0, -5.0), (0.0, 0.0, yaw_rad))


@pytest.fixture
def poses() -> PoseHistory:
    """After 10.05 s, with a pose every 0.1 s."""
    poses = PoseHistory()
    for tick in range(101):
        poses.add(tick / 10 + 0.05, pose_at(tick / 10 + 0.05))
    return poses


@pytest.mark.parametrize("time_s", [9.05, 9.97, 10.0, 10.05])
def test_between_two_it_moves_and_turns_evenly(poses: PoseHistory, time_s: float) -> None:
    found, expected = poses.at(time_s), pose_at(time_s)
    assert found is not None and found.position == pytest.approx(expected.position)
    assert math.remainder(found.euler[2] - expected.euler[2], 2 * math.pi) == pytest.approx(0.0)


def test_before_and_after_all_it_is_where_the_nearest_says(poses: PoseHistory) -> None:
    assert poses.oldest_s == pytest.approx(10.05 - KEPT_S)
    assert poses.at(0.0) == poses.at(10.05 - KEPT_S)
    assert poses.at(20.0) == poses.at(10.05)


@pytest.mark.parametrize(("time_s", "as_at_s"), [(10.07, 10.07), (10.09, 10.09), (12.0, 10.10)])
def test_its_motion_is_carried_on_as_far_as_is_asked(
    poses: PoseHistory, time_s: float, as_at_s: float
) -> None:
    found = poses.at(time_s, ahead_s=0.05)
    assert found is not None and found.position == pytest.approx(pose_at(as_at_s).position)


def test_a_clock_that_is_set_back_begins_anew(poses: PoseHistory) -> None:
    poses.add(3.0, pose_at(3.0))
    assert (poses.oldest_s, poses.newest_s) == (3.0, 3.0)
    found = poses.at(9.9)
    assert found is not None and found.position == pose_at(3.0).position


def test_none_is_known_until_position_and_attitude_have_come() -> None:
    poses, telemetry = PoseHistory(), Telemetry()
    telemetry.frame.take_home((10.0, 20.0, 0.0), 400.0)
    place: Any = dialect.MAVLink_local_position_ned_message(2000, 11.0, 22.0, -5.0, 0, 0, 0)
    turned: Any = dialect.MAVLink_attitude_message(1900, 0.1, 0.2, 0.3, 0, 0, 0)
    lost: Any = dialect.MAVLink_attitude_message(2100, math.nan, 0.2, 0.3, 0, 0, 0)
    keep_pose(poses, place, telemetry)
    assert (poses.at(2.0), poses.complete_until_s) == (None, None)
    for message in (turned, lost):
        keep_pose(poses, message, telemetry)
    assert (poses.newest_s, poses.complete_until_s) == (2.0, 1.9)
    assert poses.at(2.0) == Pose((1.0, 2.0, -5.0), (0.1, 0.2, 0.3))


def test_none_is_stored_while_the_frame_is_in_doubt() -> None:
    telemetry = Telemetry()
    telemetry.placed.anchor_at(GlobalOrigin(47.0, 8.0, 400.0))  # the autopilot's is not known
    telemetry.frame.take_home((10.0, 20.0, 0.0), 400.0)
    place: Any = dialect.MAVLink_local_position_ned_message(2000, 11.0, 22.0, -5.0, 0, 0, 0)
    telemetry.take(0.0, place)
    assert telemetry.placed.doubt is not None
    poses = PoseHistory()
    keep_pose(poses, place, telemetry)
    assert poses.newest_s is None
