"""What does the vehicle do in each flight mode?

A mode in flight answers one question each step: which `Target` shall the control cascade follow?
`FLIGHT_MODES` says for each of PX4's mode names what the mode needs before it may be flown, and
how it starts. A new mode is a new line there.

    OFFBOARD      follow the companion's setpoint
    AUTO.TAKEOFF  climb over the present position, then AUTO.LOITER
    AUTO.LOITER   stop and hold
    AUTO.MISSION  fly the mission's items (mission.py)
    AUTO.RTL      climb, fly home, land there
    AUTO.LAND     descend over the present position
    POSCTL        without a pilot's sticks: hold horizontally, sink at 0.5 m/s (seen on PX4)
    ALTCTL        the same, but level: without a position it drifts with the wind
    DESCEND       land without a position, level; shown as AUTO.LAND

Sources: PX4 user guide, "Flight Modes (Multicopter)"; PX4, src/modules/navigator/rtl.cpp (height
of the return) and mission_block.cpp (where a vehicle can stop). The autopilot decides when a mode
is entered, and when motors idle on the ground.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum
from typing import NamedTuple, Protocol

from companion.geometry import Ned, horizontal_distance
from sitl.autopilot.parameters import Parameters
from sitl.flight.controllers import Target
from sitl.flight.physics import FlightState

SINK_WITHOUT_PILOT_MPS = 0.5
REACHED_M = 0.3  # how near a height counts as reached


class Situation(NamedTuple):
    """What a mode sees.

    Attributes:
        home: where the vehicle was armed, local NED.
        setpoint: the newest valid offboard setpoint, None before the first.
        takeoff_down_m: the height that was asked for, as local NED down.
        cruise_mps: horizontal speed between places.
        is_landed: the vehicle rests on the ground.
        mission: what AUTO.MISSION flies.
    """

    state: FlightState
    home: Ned
    setpoint: Target | None
    takeoff_down_m: float
    cruise_mps: float
    is_landed: bool
    mission: Plan
    parameters: Parameters


class Plan(Protocol):
    """What a mode is made of that knows more than the vehicle's situation."""

    def start(self, now: Situation) -> FlightMode:
        """The mode in flight."""


class FlightMode(Protocol):
    """A mode being flown."""

    def target(self, now: Situation) -> Target:
        """What the control cascade shall follow in this step."""

    def successor(self, now: Situation) -> Succession | None:
        """What follows once the mode has done its work, None until then; asked at 50 Hz."""


@dataclass(frozen=True, slots=True)
class Succession:
    """A mode that follows by itself, and what people are told of it."""

    mode: str
    flying: FlightMode
    text: str = ""


class _Endless:
    def successor(self, now: Situation) -> Succession | None:
        """Nothing follows by itself."""
        return None


class Offboard(_Endless):
    """Follows the newest setpoint; brakes while there is none (armed by force)."""

    def target(self, now: Situation) -> Target:
        """The setpoint itself."""
        return now.setpoint or Target((None, None, None), (0.0, 0.0, 0.0))


@dataclass(slots=True)
class Hold(_Endless):
    """Stays at a point with a heading."""

    point: Ned
    yaw_rad: float

    @classmethod
    def start(cls, now: Situation) -> Hold:
        """Stops as soon as the vehicle can, like PX4's navigator."""
        return cls(_stopping_point(now), heading(now.state))

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
class Land(_Endless):
    """Descends over a point until the ground stops it."""

    north_m: float
    east_m: float
    yaw_rad: float

    @classmethod
    def start(cls, now: Situation) -> Land:
        """Over the point where the vehicle can stop."""
        north, east, _ = _stopping_point(now)
        return cls(north, east, heading(now.state))

    def target(self, now: Situation) -> Target:
        """Down, slower near the ground."""
        speed = descent_mps(now.home[2] - now.state.position[2], now.parameters)
        return Target((self.north_m, self.east_m, None), (0.0, 0.0, speed), yaw_rad=self.yaw_rad)


class _Leg(Enum):
    CLIMB = "climb"
    HOME = "fly home"
    WAIT = "descend to RTL_DESCEND_ALT and wait there"
    LAND = "land"


@dataclass(slots=True)
class Return(_Endless):
    """Climbs, flies home, waits there for RTL_LAND_DELAY (negative: for good), lands."""

    climb: Ned
    yaw_rad: float
    leg: _Leg = _Leg.CLIMB
    waiting_since_s: float | None = None

    @classmethod
    def start(cls, now: Situation) -> Return:
        """Climbs over the point where the vehicle can stop."""
        north, east, _ = _stopping_point(now)
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


@dataclass(slots=True)
class SinkWithoutPilot(_Endless):
    """Position control with nobody at the sticks."""

    north_m: float
    east_m: float
    yaw_rad: float

    @classmethod
    def start(cls, now: Situation) -> SinkWithoutPilot:
        """Over the point where the vehicle can stop."""
        north, east, _ = _stopping_point(now)
        return cls(north, east, heading(now.state))

    def target(self, now: Situation) -> Target:
        """Down, slowly."""
        return Target(
            (self.north_m, self.east_m, None),
            (0.0, 0.0, SINK_WITHOUT_PILOT_MPS),
            yaw_rad=self.yaw_rad,
        )


@dataclass(slots=True)
class Descend(_Endless):
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


class Need(Enum):
    """What a mode needs before it may be flown; the value says what is missing."""

    NOTHING = ""
    SETPOINTS = "no offboard signal"
    PILOT = "no manual control input"
    MISSION = "no valid mission available"


@dataclass(frozen=True, slots=True)
class ModeEntry:
    """A line of `FLIGHT_MODES`.

    Attributes:
        need: without it the mode is refused in the air, and arming in it.
        start: the mode in flight; a mode that cannot be flown here yet sinks.
        may_arm: PX4 refuses arming in modes that would land at once.
    """

    need: Need
    start: Callable[[Situation], FlightMode]
    may_arm: bool = True


FLIGHT_MODES: dict[str, ModeEntry] = {
    "OFFBOARD": ModeEntry(Need.SETPOINTS, lambda now: Offboard()),
    "AUTO.TAKEOFF": ModeEntry(Need.NOTHING, Takeoff.start),
    "AUTO.LOITER": ModeEntry(Need.NOTHING, Hold.start),
    "AUTO.RTL": ModeEntry(Need.NOTHING, Return.start, may_arm=False),
    "AUTO.LAND": ModeEntry(Need.NOTHING, Land.start, may_arm=False),
    "AUTO.MISSION": ModeEntry(Need.MISSION, lambda now: now.mission.start(now)),
    "POSCTL": ModeEntry(Need.PILOT, SinkWithoutPilot.start),
    "ALTCTL": ModeEntry(Need.PILOT, Descend.without_pilot),
    "MANUAL": ModeEntry(Need.PILOT, Descend.without_pilot),
    "STABILIZED": ModeEntry(Need.PILOT, Descend.without_pilot),
    "ACRO": ModeEntry(Need.PILOT, Descend.without_pilot),
    "DESCEND": ModeEntry(Need.NOTHING, Descend.to_land, may_arm=False),
}


def heading(state: FlightState) -> float:
    """Yaw in radians."""
    return state.euler[2]


def descent_mps(height_m: float, parameters: Parameters) -> float:
    """Speed of a landing at a height above home: slows down between MPC_LAND_ALT1 and ALT2."""
    upper, lower = parameters["MPC_LAND_ALT1"], parameters["MPC_LAND_ALT2"]
    fast, slow = parameters["MPC_Z_V_AUTO_DN"], parameters["MPC_LAND_SPEED"]
    share = (height_m - lower) / max(upper - lower, 1e-6)
    return slow + (fast - slow) * min(1.0, max(0.0, share))


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


def _stopping_point(now: Situation) -> Ned:
    """Where the vehicle can come to rest from its present velocity, at its present height."""
    north, east, down = now.state.position
    v_north, v_east, _ = now.state.velocity
    speed = math.hypot(v_north, v_east)
    acceleration = max(0.1, now.parameters["MPC_ACC_HOR"])  # any value may have been stored
    ramp_s = acceleration / max(0.1, now.parameters["MPC_JERK_AUTO"])
    braking_s = speed / (2 * acceleration) + ramp_s
    return (north + v_north * braking_s, east + v_east * braking_s, down)
