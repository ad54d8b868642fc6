"""Flights of the physics alone: with motor commands, or with the cascade at its own rate."""

from __future__ import annotations

from collections.abc import Callable

from sitl.flight.controllers import CONTROL_STEPS, Cascade, TrajectorySetpoint
from sitl.flight.physics import FlightState, Physics
from sitl.flight.rotors import Motors

DT = 0.004
CONTROL_S = CONTROL_STEPS * DT


def driven(physics: Physics, motors: Motors) -> FlightState:
    """The state after one step with these motor commands."""
    physics.follow(motors)
    physics.step()
    return physics.state


def flown(
    physics: Physics,
    cascade: Cascade,
    setpoint: TrajectorySetpoint | Callable[[float], TrajectorySetpoint],
    seconds: float,
) -> list[FlightState]:
    """Each state of a flight towards a setpoint, or one of the time since the start."""
    states = []
    for i in range(round(seconds / DT)):
        if i % CONTROL_STEPS == 0:
            wanted = setpoint(i * DT) if callable(setpoint) else setpoint
            physics.follow(cascade.step(physics.state, wanted, CONTROL_S))
        physics.step()
        states.append(physics.state)
    return states
