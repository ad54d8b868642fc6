"""The legs of a mission: how each item is flown, and when it counts as reached.

`LEGS` has a row for each item that moves the vehicle or keeps it in place. A leg gives the setpoint
of each step and says when its item counts as reached. PX4's rules:

- A place is reached within the item's radius (NAV_ACC_RAD if it has none) and NAV_MC_ALT_RAD of its
  height, and within MIS_YAW_ERR of a heading if the item has one; then the hold time passes.
- A take-off is reached by height alone, over the point where it began.
- A landing first flies to its place at the present height.

Source: PX4, src/modules/navigator/mission_block.cpp and mission.cpp. Left out: radii of loiters (a
multicopter holds at the centre), precision landing, MIS_YAW_TMT.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

from companion.geometry import Ned, horizontal_distance, wrap_angle
from sitl.autopilot.basic_modes import HoldMode, LandMode, TakeoffMode
from sitl.autopilot.mission_items import MissionCommand, MissionItem
from sitl.autopilot.situation import Situation, heading
from sitl.flight.controllers import TrajectorySetpoint


class Leg(Protocol):
    """An item being flown."""

    def setpoint(self, now: Situation) -> TrajectorySetpoint:
        """The setpoint of this step."""

    def is_done(self, now: Situation) -> bool:
        """Whether the item counts as reached."""

    def hold(self) -> HoldMode:
        """The hold that follows the leg if the mission ends there."""


@dataclass(slots=True)
class FlyTo:
    """Flies straight to a place and stays for a time.

    Attributes:
        required_yaw_rad: the heading that must be reached too; None for any.
        speed_mps: horizontal, None for the cruise speed.
        arrived_s: time of the arrival.
    """

    point: Ned
    yaw_rad: float
    required_yaw_rad: float | None
    acceptance_m: float
    stay_s: float
    speed_mps: float | None
    arrived_s: float | None = None

    def setpoint(self, now: Situation) -> TrajectorySetpoint:
        """The place."""
        speed_mps = self.speed_mps or now.cruise_mps
        return TrajectorySetpoint(
            self.point, (0.0, 0.0, 0.0), yaw_rad=self.yaw_rad, speed_mps=speed_mps
        )

    def is_done(self, now: Situation) -> bool:
        """Arrived, and stayed."""
        if self.arrived_s is None and self._has_arrived(now):
            self.arrived_s = now.state.time_s
        return self.arrived_s is not None and now.state.time_s - self.arrived_s >= self.stay_s

    def hold(self) -> HoldMode:
        """At the place."""
        return HoldMode(self.point, self.yaw_rad)

    def _has_arrived(self, now: Situation) -> bool:
        position = now.state.position
        if horizontal_distance(position, self.point) > self.acceptance_m:
            return False
        if abs(position[2] - self.point[2]) > now.parameters["NAV_MC_ALT_RAD"]:
            return False
        if self.required_yaw_rad is None:
            return True
        error_rad = abs(wrap_angle(self.required_yaw_rad - heading(now.state)))
        return error_rad < math.radians(now.parameters["MIS_YAW_ERR"])


@dataclass(slots=True)
class Climb:
    """Takes off over the present place."""

    point: Ned
    yaw_rad: float
    acceptance_m: float

    @classmethod
    def to(cls, down_m: float, now: Situation) -> Climb:
        """To a height in local NED, from the ground at least MIS_TAKEOFF_ALT."""
        north, east, down = now.state.position
        if now.is_landed:
            down_m = min(down_m, down - now.parameters["MIS_TAKEOFF_ALT"])
        height_m = now.home[2] - down_m
        acceptance_m = now.parameters["NAV_MC_ALT_RAD"]
        if 0 < height_m < acceptance_m:
            acceptance_m = height_m / 2
        return cls((north, east, down_m), heading(now.state), acceptance_m)

    def setpoint(self, now: Situation) -> TrajectorySetpoint:
        """Up, slower near the height."""
        return TakeoffMode(self.point, self.yaw_rad).setpoint(now)

    def is_done(self, now: Situation) -> bool:
        """High enough."""
        return now.state.position[2] < self.point[2] + self.acceptance_m

    def hold(self) -> HoldMode:
        """At the height."""
        return HoldMode(self.point, self.yaw_rad)


@dataclass(slots=True)
class LandAt:
    """Flies to a place at the present height and lands there."""

    point: Ned
    yaw_rad: float
    speed_mps: float | None
    is_descending: bool = False

    def setpoint(self, now: Situation) -> TrajectorySetpoint:
        """The place, then down."""
        if self.is_descending:
            return LandMode(self.point[0], self.point[1], self.yaw_rad).setpoint(now)
        speed_mps = self.speed_mps or now.cruise_mps
        return TrajectorySetpoint(
            self.point, (0.0, 0.0, 0.0), yaw_rad=self.yaw_rad, speed_mps=speed_mps
        )

    def is_done(self, now: Situation) -> bool:
        """On the ground."""
        away_m = horizontal_distance(now.state.position, self.point)
        self.is_descending = self.is_descending or away_m <= now.parameters["NAV_ACC_RAD"]
        return now.is_landed

    def hold(self) -> HoldMode:
        """Over the place."""
        return HoldMode(self.point, self.yaw_rad)


@dataclass(slots=True)
class Delay:
    """Stays at the place of the item before."""

    place: HoldMode
    until_s: float

    def setpoint(self, now: Situation) -> TrajectorySetpoint:
        """The same place."""
        return self.place.setpoint(now)

    def is_done(self, now: Situation) -> bool:
        """The time is over."""
        return now.state.time_s >= self.until_s

    def hold(self) -> HoldMode:
        """The same place."""
        return self.place


def _fly_to(item: MissionItem, now: Situation, speed_mps: float | None, stay_s: float) -> FlyTo:
    here = now.state.position
    point = item.point(here, now.home)
    wanted = item.yaw_rad
    yaw_rad = _heading_to(point, now) if wanted is None else wanted
    acceptance_m = item.parameter(2) if item.command == MissionCommand.WAYPOINT else 0.0
    if acceptance_m <= 0:
        acceptance_m = now.parameters["NAV_ACC_RAD"]
    return FlyTo(point, yaw_rad, wanted, acceptance_m, stay_s, speed_mps)


def _timed(item: MissionItem, now: Situation, speed_mps: float | None, before: HoldMode) -> Leg:
    return _fly_to(item, now, speed_mps, stay_s=item.parameter(1))


def _endless(item: MissionItem, now: Situation, speed_mps: float | None, before: HoldMode) -> Leg:
    return _fly_to(item, now, speed_mps, stay_s=math.inf)


def _take_off(item: MissionItem, now: Situation, speed_mps: float | None, before: HoldMode) -> Leg:
    return Climb.to(item.point(now.state.position, now.home)[2], now)


def _land(item: MissionItem, now: Situation, speed_mps: float | None, before: HoldMode) -> Leg:
    north, east, _ = item.point(now.state.position, now.home)
    point = (north, east, now.state.position[2])
    return LandAt(point, _heading_to(point, now), speed_mps)


def _delay(item: MissionItem, now: Situation, speed_mps: float | None, before: HoldMode) -> Leg:
    return Delay(before, now.state.time_s + item.parameter(1))


def _heading_to(point: Ned, now: Situation) -> float:
    """MPC_YAW_MODE 0: towards the place, as long as it is not too near to tell where that is."""
    north, east, _ = now.state.position
    if horizontal_distance(point, now.state.position) <= now.parameters["NAV_ACC_RAD"]:
        return heading(now.state)
    return math.atan2(point[1] - east, point[0] - north)


LegFactory = Callable[[MissionItem, Situation, float | None, HoldMode], Leg]

LEGS: dict[int, LegFactory] = {
    MissionCommand.WAYPOINT: _timed,
    MissionCommand.LOITER_UNLIMITED: _endless,
    MissionCommand.LOITER_TIME: _timed,
    MissionCommand.LAND: _land,
    MissionCommand.TAKEOFF: _take_off,
    MissionCommand.DELAY: _delay,
}
"""MAV_CMD -> its leg, made from the item, the situation, the speed and the last leg's hold."""

NEEDS_HEIGHT = frozenset(
    {MissionCommand.WAYPOINT, MissionCommand.LOITER_UNLIMITED, MissionCommand.LOITER_TIME}
)
"""On the ground, a take-off is inserted before these items."""
