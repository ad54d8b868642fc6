"""AUTO.RTL: the return to home, or to a rally point, and the landing there.

Source: PX4, src/modules/navigator/rtl.cpp (height of the return); return_destination.py.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum

from companion.geometry import Ned, horizontal_distance
from sitl.autopilot.basic_modes import REACHED_M, LandMode, OpenEndedMode
from sitl.autopilot.parameters import Parameters
from sitl.autopilot.return_destination import return_destination
from sitl.autopilot.situation import Situation, heading, stopping_point
from sitl.flight.controllers import TrajectorySetpoint


class ReturnPhase(Enum):
    """The phases of a return, in order; each may end at once."""

    CLIMB = "climb"
    CROSS = "fly to where it lands"
    WAIT = "descend to RTL_DESCEND_ALT and wait there"
    LAND = "land"


@dataclass(slots=True)
class ReturnMode(OpenEndedMode):
    """Climbs, flies to its destination, waits RTL_LAND_DELAY (negative: for ever), lands.

    The destination is chosen at the start.
    """

    destination: Ned
    climb: Ned
    yaw_rad: float
    phase: ReturnPhase = ReturnPhase.CLIMB
    waiting_since_s: float | None = None

    @classmethod
    def start(cls, now: Situation) -> ReturnMode:
        """Climbs over the point where the vehicle can stop."""
        position, parameters = now.state.position, now.parameters
        destination = return_destination(
            position, home=now.home, safe_points=now.safe_points, return_type=parameters["RTL_TYPE"]
        )
        north, east, _ = stopping_point(now)
        down = destination[2] - return_height_m(position, destination, parameters)
        return cls(destination, (north, east, down), heading(now.state))

    def setpoint(self, now: Situation) -> TrajectorySetpoint:
        """The setpoint of the present phase."""
        self._update_phase(now)
        there = self.destination
        if self.phase is ReturnPhase.LAND:
            return LandMode(there[0], there[1], self.yaw_rad).setpoint(now)
        if self.phase is ReturnPhase.WAIT:
            down = max(self.climb[2], there[2] - now.parameters["RTL_DESCEND_ALT"])
            return TrajectorySetpoint(
                (there[0], there[1], down), (0.0, 0.0, 0.0), yaw_rad=self.yaw_rad
            )
        is_climbing = self.phase is ReturnPhase.CLIMB
        at = self.climb if is_climbing else (there[0], there[1], self.climb[2])
        return TrajectorySetpoint(
            at, (0.0, 0.0, 0.0), yaw_rad=self.yaw_rad, speed_mps=now.cruise_mps
        )

    def _update_phase(self, now: Situation) -> None:
        position = now.state.position
        if self.phase is ReturnPhase.CLIMB and position[2] < self.climb[2] + REACHED_M:
            self.phase = ReturnPhase.CROSS
        is_there = horizontal_distance(position, self.destination) < now.parameters["NAV_ACC_RAD"]
        if self.phase is ReturnPhase.CROSS and is_there:
            self.phase = ReturnPhase.WAIT
        if self.phase is ReturnPhase.WAIT and self._has_waited(now):
            self.phase = ReturnPhase.LAND

    def _has_waited(self, now: Situation) -> bool:
        delay_s = now.parameters["RTL_LAND_DELAY"]
        down = self.destination[2] - now.parameters["RTL_DESCEND_ALT"]
        if self.waiting_since_s is None and now.state.position[2] > down - REACHED_M:
            self.waiting_since_s = now.state.time_s
        if delay_s <= 0:
            return delay_s == 0
        since = self.waiting_since_s
        return since is not None and now.state.time_s - since >= delay_s


def return_height_m(position: Ned, home: Ned, parameters: Parameters) -> float:
    """Height above home at which to return: RTL_RETURN_ALT, or less inside a cone near home.

    Never below the present height (PX4, RTL::calculate_return_alt_from_cone_half_angle).
    """
    away_m = horizontal_distance(position, home)
    acceptance_m = parameters["NAV_ACC_RAD"]
    if away_m <= acceptance_m:
        height = 2 * away_m
    else:
        height = parameters["RTL_RETURN_ALT"]
        if away_m <= parameters["RTL_MIN_DIST"]:
            half_angle = math.radians(min(89.0, max(1.0, parameters["RTL_CONE_ANG"])))
            height = min(height, away_m / math.tan(half_angle))
        height = max(height, 2 * acceptance_m)
    return max(height, home[2] - position[2])
