"""What does the vehicle do in a mode with one thing to do: follow, hold, climb, descend?

Source: PX4 user guide, "Flight Modes (Multicopter)"; PX4, src/modules/navigator/mission_block.cpp
(where a vehicle can stop).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

from companion.geometry import Ned
from sitl.autopilot.parameters import Parameters
from sitl.autopilot.situation import Situation, Succession, heading, stopping_point
from sitl.flight.controllers import Target

SINK_WITHOUT_PILOT_MPS = 0.5
REACHED_M = 0.3  # how near a height counts as reached


class Endless:
    """A mode that goes on until another one is asked for."""

    def successor(self, now: Situation) -> Succession | None:
        """Nothing follows by itself."""
        return None


class Offboard(Endless):
    """Follows the newest setpoint; brakes while there is none (armed by force)."""

    def target(self, now: Situation) -> Target:
        """The setpoint itself."""
        return now.setpoint or Target((None, None, None), (0.0, 0.0, 0.0))


@dataclass(slots=True)
class Hold(Endless):
    """Stays at a point with a heading."""

    point: Ned
    yaw_rad: float

    @classmethod
    def start(cls, now: Situation) -> Hold:
        """Stops as soon as the vehicle can, like PX4's navigator."""
        return cls(stopping_point(now), heading(now.state))

    def target(self, now: Situation) -> Target:
        """The point."""
        return Target(self.point, (0.0, 0.0, 0.0), yaw_rad=self.yaw_rad, speed_mps=now.cruise_mps)


@dataclass(slots=True)
class Takeoff:
    """Climbs over a point."""

    point: Ned
    yaw_rad: float

    @classmethod
    def start(cls, now: Situation) -> Takeoff:
        """Climbs to the height that was asked for; never descends."""
        north, east, down = now.state.position
        return cls((north, east, min(down, now.takeoff_down_m)), heading(now.state))

    def target(self, now: Situation) -> Target:
        """Up, slower near the height."""
        north, east, down = self.point
        speed = min(now.parameters["MPC_TKO_SPEED"], now.state.position[2] - down)
        return Target((north, east, None), (0.0, 0.0, -speed), yaw_rad=self.yaw_rad)

    def successor(self, now: Situation) -> Succession | None:
        """Holds at the height that was asked for."""
        is_reached = abs(now.state.position[2] - self.point[2]) < REACHED_M
        return Succession("AUTO.LOITER", Hold(self.point, self.yaw_rad)) if is_reached else None


@dataclass(slots=True)
class Land(Endless):
    """Descends over a point until the ground stops it."""

    north_m: float
    east_m: float
    yaw_rad: float

    @classmethod
    def start(cls, now: Situation) -> Self:
        """Over the point where the vehicle can stop."""
        north, east, _ = stopping_point(now)
        return cls(north, east, heading(now.state))

    def target(self, now: Situation) -> Target:
        """Down."""
        speed = self._speed_mps(now)
        return Target((self.north_m, self.east_m, None), (0.0, 0.0, speed), yaw_rad=self.yaw_rad)

    def _speed_mps(self, now: Situation) -> float:
        """Slower near the ground."""
        return descent_mps(now.home[2] - now.state.position[2], now.parameters)


class SinkWithoutPilot(Land):
    """Position control with nobody at the sticks: a landing at one speed."""

    def _speed_mps(self, now: Situation) -> float:
        return SINK_WITHOUT_PILOT_MPS


@dataclass(slots=True)
class Descend(Endless):
    """Goes down level, wherever the wind takes it: nothing else is possible without a position."""

    yaw_rad: float
    down_parameter: str | None = None

    @classmethod
    def without_pilot(cls, now: Situation) -> Descend:
        """Altitude control with nobody at the sticks."""
        return cls(heading(now.state))

    @classmethod
    def to_land(cls, now: Situation) -> Descend:
        """A blind landing."""
        return cls(heading(now.state), "MPC_LAND_SPEED")

    def target(self, now: Situation) -> Target:
        """Down, level."""
        name = self.down_parameter
        speed = now.parameters[name] if name else SINK_WITHOUT_PILOT_MPS
        return Target((None, None, None), (None, None, speed), yaw_rad=self.yaw_rad)


def descent_mps(height_m: float, parameters: Parameters) -> float:
    """Speed of a landing at a height above home: slows down between MPC_LAND_ALT1 and ALT2."""
    upper, lower = parameters["MPC_LAND_ALT1"], parameters["MPC_LAND_ALT2"]
    fast, slow = parameters["MPC_Z_V_AUTO_DN"], parameters["MPC_LAND_SPEED"]
    share = (height_m - lower) / max(upper - lower, 1e-6)
    return slow + (fast - slow) * min(1.0, max(0.0, share))
