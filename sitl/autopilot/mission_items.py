"""The items of a mission, as the autopilot flies them.

A `MissionItem` is one of PX4's mission items, with its place already in local NED. Only those in
`MissionCommand` change the flight; all others (cameras, gimbals, regions of interest) are skipped
at once. A value that was not given, NaN on the wire, is None here.

Source: MAV_CMD in common.xml; PX4, src/modules/navigator/mission_base.cpp.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from enum import IntEnum

from companion.geometry import Ned, NorthEast, wrap_angle

MANY_JUMPS = 65535  # a negative count of repetitions: PX4 keeps it in 16 bits


class MissionCommand(IntEnum):
    """The items that change the flight; the values are MAV_CMD."""

    WAYPOINT = 16
    LOITER_UNLIMITED = 17
    LOITER_TIME = 19
    RETURN_TO_LAUNCH = 20
    LAND = 21
    TAKEOFF = 22
    DELAY = 93
    DO_JUMP = 177
    DO_CHANGE_SPEED = 178


@dataclass(frozen=True, slots=True)
class MissionItem:
    """One item of a mission.

    Attributes:
        command: MAV_CMD; may be one that is skipped.
        parameters: param1 to param4; finite, or None if not given.
        place: local north and east; None means wherever the vehicle is.
        up_m: height above home or above the local origin; None means the present height.
        is_above_home: which of the two.
        autocontinue: whether the next item follows by itself.
    """

    command: int
    parameters: tuple[float | None, float | None, float | None, float | None] = (None,) * 4
    place: NorthEast | None = None
    up_m: float | None = None
    is_above_home: bool = True
    autocontinue: bool = True

    def parameter(self, number: int, default: float = 0.0) -> float:
        """One of param1 to param4, or the default if it was not given."""
        value = self.parameters[number - 1]
        return default if value is None else value

    def point(self, here: Ned, home: Ned) -> Ned:
        """The place in local NED."""
        north, east = self.place or here[:2]
        if self.up_m is None:
            return (north, east, here[2])
        return (north, east, (home[2] if self.is_above_home else 0.0) - self.up_m)

    @property
    def yaw_rad(self) -> float | None:
        """The heading at a waypoint, None for any."""
        yaw_deg = self.parameters[3]
        return None if yaw_deg is None else wrap_angle(math.radians(yaw_deg))

    @property
    def jumps_to(self) -> int:
        """The item to which a DO_JUMP leads."""
        return int(self.parameter(1, -1.0))

    @property
    def repetitions(self) -> int:
        """How often a DO_JUMP jumps."""
        count = self.parameter(2)
        return MANY_JUMPS if count < 0 else int(min(count, MANY_JUMPS))


def speed_before(items: Sequence[MissionItem], index: int) -> float | None:
    """The speed in m/s that applies when an item begins; None for the default."""
    changes = [item for item in items[:index] if item.command == MissionCommand.DO_CHANGE_SPEED]
    speed_mps = changes[-1].parameter(2) if changes else 0.0
    return speed_mps if speed_mps > 0 else None
