"""The interface between the autopilot and a flight mode.

A mode in flight takes a `Situation` and returns the `TrajectorySetpoint` for the control cascade.
It also says which mode follows by itself, if any.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple, Protocol

from companion.geometry import Ned
from sitl.autopilot.parameters import Parameters
from sitl.autopilot.return_destination import SafePoint
from sitl.flight.controllers import TrajectorySetpoint
from sitl.flight.physics import FlightState


class Situation(NamedTuple):
    """The inputs of a flight mode.

    Attributes:
        home: where the vehicle was armed, local NED.
        offboard_setpoint: the newest valid one; None before the first.
        takeoff_down_m: the height to which a take-off climbs, as local NED down.
        cruise_mps: horizontal speed between places.
        is_landed: whether the vehicle rests on the ground.
        mission: flown by AUTO.MISSION.
        safe_points: rally points.
    """

    state: FlightState
    home: Ned
    offboard_setpoint: TrajectorySetpoint | None
    takeoff_down_m: float
    cruise_mps: float
    is_landed: bool
    mission: ModeFactory
    parameters: Parameters
    safe_points: tuple[SafePoint, ...] = ()


class ModeFactory(Protocol):
    """Starts a mode that needs more than the vehicle's situation."""

    def start(self, now: Situation) -> FlightMode:
        """The mode in flight."""


class FlightMode(Protocol):
    """A mode being flown."""

    def setpoint(self, now: Situation) -> TrajectorySetpoint:
        """The setpoint of this step."""

    def mode_change(self, now: Situation) -> ModeChange | None:
        """The mode that follows once this one is done; None until then. Called at 50 Hz."""


@dataclass(frozen=True, slots=True)
class ModeChange:
    """A mode that follows by itself, with its text for people, if it has one."""

    mode: str
    flying: FlightMode
    text: str | None = None


def heading(state: FlightState) -> float:
    """Yaw in radians."""
    return state.euler[2]


def stopping_point(now: Situation) -> Ned:
    """The point where the vehicle can come to rest, at its present height."""
    north, east, down = now.state.position
    v_north, v_east, _ = now.state.velocity
    speed = math.hypot(v_north, v_east)
    acceleration = max(0.1, now.parameters["MPC_ACC_HOR"])  # any value may be stored
    ramp_s = acceleration / max(0.1, now.parameters["MPC_JERK_AUTO"])
    braking_s = speed / (2 * acceleration) + ramp_s
    return (north + v_north * braking_s, east + v_east * braking_s, down)
