"""How does the vehicle come home by itself (AUTO.RTL)?

Source: PX4, src/modules/navigator/rtl.cpp (height of the return).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum

from companion.geometry import Ned, horizontal_distance
from sitl.autopilot.basic_modes import REACHED_M, Endless, Land
from sitl.autopilot.parameters import Parameters
from sitl.autopilot.situation import Situation, heading, stopping_point
from sitl.flight.controllers import Target


class _Leg(Enum):
    CLIMB = "climb"
    HOME = "fly home"
    WAIT = "descend to RTL_DESCEND_ALT and wait there"
    LAND = "land"


@dataclass(slots=True)
class Return(Endless):
    """Climbs, flies home, waits there for RTL_LAND_DELAY (negative: for good), lands."""

    climb: Ned
    yaw_rad: float
    leg: _Leg = _Leg.CLIMB
    waiting_since_s: float | None = None

    @classmethod
    def start(cls, now: Situation) -> Return:
        """Climbs over the point where the vehicle can stop."""
        north, east, _ = stopping_point(now)
        down = now.home[2] - return_height_m(now.state.position, now.home, now.parameters)
        return cls((north, east, down), heading(now.state))

    def target(self, now: Situation) -> Target:
        """The goal of the present leg."""
        position, home = now.state.position, now.home
        if self.leg is _Leg.CLIMB and position[2] < self.climb[2] + REACHED_M:
            self.leg = _Leg.HOME
        is_home = horizontal_distance(position, home) < now.parameters["NAV_ACC_RAD"]
        if self.leg is _Leg.HOME and is_home:
            self.leg = _Leg.WAIT
        if self.leg is _Leg.WAIT and self._has_waited(now):
            self.leg = _Leg.LAND
        if self.leg is _Leg.LAND:
            return Land(home[0], home[1], self.yaw_rad).target(now)
        if self.leg is _Leg.WAIT:
            down = max(self.climb[2], home[2] - now.parameters["RTL_DESCEND_ALT"])
            return Target((home[0], home[1], down), (0.0, 0.0, 0.0), yaw_rad=self.yaw_rad)
        at = self.climb if self.leg is _Leg.CLIMB else (home[0], home[1], self.climb[2])
        return Target(at, (0.0, 0.0, 0.0), yaw_rad=self.yaw_rad, speed_mps=now.cruise_mps)

    def _has_waited(self, now: Situation) -> bool:
        delay_s = now.parameters["RTL_LAND_DELAY"]
        down = now.home[2] - now.parameters["RTL_DESCEND_ALT"]
        if self.waiting_since_s is None and now.state.position[2] > down - REACHED_M:
            self.waiting_since_s = now.state.time_s
        if delay_s <= 0:
            return delay_s == 0
        since = self.waiting_since_s
        return since is not None and now.state.time_s - since >= delay_s


def return_height_m(position: Ned, home: Ned, parameters: Parameters) -> float:
    """Height above home at which to return: RTL_RETURN_ALT, less inside a cone near home.

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
