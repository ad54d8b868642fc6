"""The modes with a single behaviour: follow setpoints, hold, climb, descend.

Source: PX4 user guide, "Flight Modes (Multicopter)"; PX4, src/modules/navigator/mission_block.cpp
(where a vehicle can stop).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

from companion.geometry import Ned
from sitl.autopilot.parameters import Parameters
from sitl.autopilot.situation import ModeChange, Situation, heading, stopping_point
from sitl.flight.controllers import TrajectorySetpoint

SINK_WITHOUT_STICKS_MPS = 0.5
REACHED_M = 0.3  # a height counts as reached within this


class OpenEndedMode:
    """A mode that lasts until another one is commanded."""

    def mode_change(self, now: Situation) -> ModeChange | None:
        """No mode follows by itself."""
        return None


class OffboardMode(OpenEndedMode):
    """Follows the newest setpoint; brakes while there is none (armed by force)."""

    def setpoint(self, now: Situation) -> TrajectorySetpoint:
        """The setpoint itself."""
        return now.offboard_setpoint or TrajectorySetpoint((None, None, None), (0.0, 0.0, 0.0))


@dataclass(slots=True)
class HoldMode(OpenEndedMode):
    """Stays at a point with a heading."""

    point: Ned
    yaw_rad: float

    @classmethod
    def start(cls, now: Situation) -> HoldMode:
        """Stops as soon as the vehicle can, like PX4's navigator."""
        return cls(stopping_point(now), heading(now.state))

    def setpoint(self, now: Situation) -> TrajectorySetpoint:
        """The point."""
        return TrajectorySetpoint(
            self.point, (0.0, 0.0, 0.0), yaw_rad=self.yaw_rad, speed_mps=now.cruise_mps
        )


@dataclass(slots=True)
class TakeoffMode:
    """Climbs over a point."""

    point: Ned
    yaw_rad: float

    @classmethod
    def start(cls, now: Situation) -> TakeoffMode:
        """Climbs to the height of the situation; never descends."""
        north, east, down = now.state.position
        return cls((north, east, min(down, now.takeoff_down_m)), heading(now.state))

    def setpoint(self, now: Situation) -> TrajectorySetpoint:
        """Up, slower near the height."""
        north, east, down = self.point
        speed = min(now.parameters["MPC_TKO_SPEED"], now.state.position[2] - down)
        return TrajectorySetpoint((north, east, None), (0.0, 0.0, -speed), yaw_rad=self.yaw_rad)

    def mode_change(self, now: Situation) -> ModeChange | None:
        """AUTO.LOITER at the height, once it is reached."""
        is_reached = abs(now.state.position[2] - self.point[2]) < REACHED_M
        return ModeChange("AUTO.LOITER", HoldMode(self.point, self.yaw_rad)) if is_reached else None


@dataclass(slots=True)
class LandMode(OpenEndedMode):
    """Descends over a point until the ground stops it."""

    north_m: float
    east_m: float
    yaw_rad: float

    @classmethod
    def start(cls, now: Situation) -> Self:
        """Lands below the point where the vehicle can stop."""
        north, east, _ = stopping_point(now)
        return cls(north, east, heading(now.state))

    def setpoint(self, now: Situation) -> TrajectorySetpoint:
        """Down."""
        speed = self._speed_mps(now)
        return TrajectorySetpoint(
            (self.north_m, self.east_m, None), (0.0, 0.0, speed), yaw_rad=self.yaw_rad
        )

    def _speed_mps(self, now: Situation) -> float:
        """Slower near the ground."""
        return descent_mps(now.home[2] - now.state.position[2], now.parameters)


class PositionMode(LandMode):
    """Position control without a pilot's sticks: a landing at one speed."""

    def _speed_mps(self, now: Situation) -> float:
        return SINK_WITHOUT_STICKS_MPS


@dataclass(slots=True)
class DescendMode(OpenEndedMode):
    """Descends level and drifts with the wind; needs no position."""

    yaw_rad: float
    down_parameter: str | None = None

    @classmethod
    def without_sticks(cls, now: Situation) -> DescendMode:
        """Altitude control without a pilot's sticks."""
        return cls(heading(now.state))

    @classmethod
    def to_land(cls, now: Situation) -> DescendMode:
        """A landing without a position."""
        return cls(heading(now.state), "MPC_LAND_SPEED")

    def setpoint(self, now: Situation) -> TrajectorySetpoint:
        """Down, level."""
        name = self.down_parameter
        speed = now.parameters[name] if name else SINK_WITHOUT_STICKS_MPS
        return TrajectorySetpoint((None, None, None), (None, None, speed), yaw_rad=self.yaw_rad)


def descent_mps(height_m: float, parameters: Parameters) -> float:
    """Speed of a landing at a height above home: slows down between MPC_LAND_ALT1 and ALT2."""
    upper, lower = parameters["MPC_LAND_ALT1"], parameters["MPC_LAND_ALT2"]
    fast, slow = parameters["MPC_Z_V_AUTO_DN"], parameters["MPC_LAND_SPEED"]
    share = (height_m - lower) / max(upper - lower, 1e-6)
    return slow + (fast - slow) * min(1.0, max(0.0, share))
