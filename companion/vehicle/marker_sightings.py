"""Converts sightings of landing markers (LANDING_TARGET) to positions in the mission's frame.

A detector on board sends them. It stamps them with the autopilot's time since boot, which it knows
by TIMESYNC. These forms are accepted:

    position_valid 1, MAV_FRAME_LOCAL_NED      where the marker is in the autopilot's local frame
    position_valid 1, MAV_FRAME_BODY_FRD       from the vehicle to the marker, along the body's axes
    position_valid 1, MAV_FRAME_LOCAL_FRD      the same, level, along the heading
    position_valid 0, with a distance          angles from the middle of the image of a camera that
                                               looks down: angle_x to the right, angle_y backwards

Everything else is refused, with a reason: other frames; angles without a distance (they would need
the height above the marker, which nobody has measured); numbers that are not finite; a component
that the mission does not name; a sighting more than OLD_S old. A stamp more than APART_S from the
autopilot's time comes from another clock; such a sighting is taken to be as old as the newest
position.

Source: common.xml; https://mavlink.io/en/services/landing_target.html.
"""

from __future__ import annotations

import math
from collections.abc import Collection

from companion.geometry import Ned
from companion.mavlink.framing import Message, dialect, source
from companion.outcomes import Refusal
from companion.vehicle.ports.markers import MarkerSighting
from companion.vehicle.poses import Pose, PoseHistory
from companion.vehicle.services import Moment
from companion.vehicle.telemetry import Telemetry

OLD_S = 0.5
APART_S = 5.0
FAR_M = 100.0
"""A marker is not seen from farther away."""
MOST = 40
"""Sightings that are evaluated in a tick of 50 ms."""
MESSAGE = "LANDING_TARGET"


_IS_LEVEL = {dialect.MAV_FRAME_BODY_FRD: False, dialect.MAV_FRAME_LOCAL_FRD: True}
"""Frames relative to the vehicle -> whether they are turned by the heading only."""


class MarkerSightings:
    """Sightings of markers; a service of the vehicle, and `ports.markers.Markers`.

    Args:
        telemetry: of the vehicle.
        components: ids of the components whose sightings are accepted.
        poses: of the vehicle, by the autopilot's time since boot.

    Attributes:
        seen: sightings since the tick before, in order.
        refused: why others were refused.
    """

    wanted = frozenset({MESSAGE})
    needs_control = False

    def __init__(
        self, telemetry: Telemetry, components: Collection[int], poses: PoseHistory
    ) -> None:
        self.seen: list[MarkerSighting] = []
        self.refused: list[Refusal] = []
        self._telemetry = telemetry
        self._components = components
        self._poses = poses

    def step(self, moment: Moment) -> None:
        """Drops the sightings of the previous tick."""
        self.seen, self.refused = [], []

    def take(self, moment: Moment, message: Message) -> None:
        """Takes a sighting."""
        if len(self.seen) + len(self.refused) >= MOST:
            return
        outcome = self._read(moment, source(message)[1], message)
        if isinstance(outcome, Refusal):
            self.refused.append(outcome)
        else:
            self.seen.append(outcome)

    def due(self, moment: Moment) -> list[Message]:
        """Nothing; this service only listens."""
        return []

    def release(self) -> None:
        """Drops all sightings."""
        self.seen, self.refused = [], []

    def _read(self, moment: Moment, component: int, message: Message) -> MarkerSighting | Refusal:
        if component not in self._components:
            return Refusal(f"component {component} is not one that the mission names")
        newest_s = self._poses.newest_s
        if newest_s is None or self._telemetry.placed.doubt is not None:
            return Refusal("the vehicle's own position is not known")
        boot_s = message.time_usec / 1e6
        age_s = newest_s - boot_s
        if abs(age_s) > APART_S:
            boot_s, age_s = newest_s, 0.0
        if age_s > OLD_S:
            return Refusal(f"it is {age_s:.1f} s old")
        pose = self._poses.at(boot_s)
        position = self._position(message, pose) if pose is not None else Refusal("no attitude")
        if isinstance(position, Refusal):
            return position
        seen_s = moment.now_s - max(age_s, 0.0)
        return MarkerSighting(seen_s, component, message.target_num, position)

    def _position(self, message: Message, pose: Pose) -> Ned | Refusal:
        is_position = bool(message.position_valid)
        numbers = (
            (message.x, message.y, message.z)
            if is_position
            else (message.angle_x, message.angle_y, message.distance)
        )
        if not all(map(math.isfinite, numbers)):
            return Refusal("it is not finite")
        if is_position and message.frame == dialect.MAV_FRAME_LOCAL_NED:
            position = self._telemetry.frame.position(numbers)
        elif is_position and message.frame in _IS_LEVEL:
            offset = turned(numbers, pose.euler, _IS_LEVEL[message.frame])
            position = _sum(pose.position, offset)
        elif is_position:
            return Refusal(f"its frame is {message.frame}: LOCAL_NED, BODY_FRD, LOCAL_FRD are read")
        elif not message.distance > 0:
            return Refusal("it has angles and no distance")
        else:
            position = _sum(pose.position, turned(_ray(*numbers), pose.euler, is_level=False))
        far_m = math.dist(position, pose.position)
        return position if far_m <= FAR_M else Refusal(f"it is {far_m:.0f} m away")


def _ray(right_rad: float, back_rad: float, distance_m: float) -> Ned:
    """Forward, right and down from a camera that looks down to what it sees."""
    forward, right = -math.tan(back_rad), math.tan(right_rad)
    scale = distance_m / math.hypot(forward, right, 1.0)
    return (forward * scale, right * scale, scale)


def turned(body: Ned, euler: Ned, is_level: bool) -> Ned:
    """Turns a vector from body axes to north, east, down.

    >>> [round(x, 3) for x in turned((1.0, 0.0, 0.0), (0.0, 0.0, math.pi / 2), is_level=False)]
    [0.0, 1.0, 0.0]

    Args:
        body: forward, right, down.
        euler: roll, pitch, yaw; rad.
        is_level: turn by the yaw only.
    """
    roll, pitch, yaw = (0.0, 0.0, euler[2]) if is_level else euler
    x, y, z = body
    y, z = y * math.cos(roll) - z * math.sin(roll), y * math.sin(roll) + z * math.cos(roll)
    x, z = x * math.cos(pitch) + z * math.sin(pitch), -x * math.sin(pitch) + z * math.cos(pitch)
    x, y = x * math.cos(yaw) - y * math.sin(yaw), x * math.sin(yaw) + y * math.cos(yaw)
    return (x, y, z)


def _sum(a: Ned, b: Ned) -> Ned:
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2])
