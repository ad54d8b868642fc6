"""What does a flight mode see, and what does it answer?

A mode in flight answers one question each step: which `Target` shall the control cascade follow?
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple, Protocol

from companion.geometry import Ned
from sitl.autopilot.parameters import Parameters
from sitl.flight.controllers import Target
from sitl.flight.physics import FlightState


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


def heading(state: FlightState) -> float:
    """Yaw in radians."""
    return state.euler[2]


def stopping_point(now: Situation) -> Ned:
    """Where the vehicle can come to rest from its present velocity, at its present height."""
    north, east, down = now.state.position
    v_north, v_east, _ = now.state.velocity
    speed = math.hypot(v_north, v_east)
    acceleration = max(0.1, now.parameters["MPC_ACC_HOR"])  # any value may have been stored
    ramp_s = acceleration / max(0.1, now.parameters["MPC_JERK_AUTO"])
    braking_s = speed / (2 * acceleration) + ramp_s
    return (north + v_north * braking_s, east + v_east * braking_s, down)
