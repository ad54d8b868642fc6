"""How a flight begins and goes on: what the vehicle is told, from where it is and how it moves."""

from __future__ import annotations

import math

import pytest
from leaves import tick
from py_trees.common import Status
from rig import Rig
from synthetic import mission

from companion.acting.behaviour_tree.move import MoveCommand
from companion.acting.guidance import HELD_M, LAG_SHARE, Guidance
from companion.tick import TICK_S
from companion.vehicle.ports.state import EXTRAPOLATED_S


def stopping() -> Rig:
    """A vehicle that has given up a flight."""
    rig = Rig(mission("F at(A)"))
    leaf = MoveCommand(rig.flight, "A", None)
    for _ in range(40):
        tick(rig, leaf)
    leaf.stop(Status.INVALID)
    return rig


def speed_mps(guidance: Guidance) -> float:
    assert guidance.departure is not None
    return math.hypot(*guidance.departure.now.velocity)


def test_a_flight_begins_with_the_motion_that_the_vehicle_is_told() -> None:
    rig = stopping()
    guidance, vehicle = rig.flight.guidance, rig.vehicle
    told = guidance.departure
    assert told is not None and guidance.setpoint is not None and told.stop is guidance.stop
    assert told.now.position == guidance.setpoint.position and speed_mps(guidance) > 1.5
    vehicle.change(velocity=(0.0, 1.0, 0.0))
    assert guidance.departure == told
    rest, left_s = told.rest
    while guidance.stop is not None:
        rig.pass_time()
        guidance.brake()
    guidance.hold()
    assert guidance.departure is not None and guidance.departure.now.position == rest
    assert speed_mps(guidance) == 0.0 and 1.0 < left_s < 2.0


def test_a_vehicle_is_compared_with_its_setpoint_where_it_is_by_now() -> None:
    """Its position is 0.1 s old; and between two ticks it follows the middle of a step."""
    rig = stopping()
    guidance, vehicle = rig.flight.guidance, rig.vehicle
    assert vehicle.state is not None and guidance.setpoint is not None
    here, measured_s = vehicle.state.motion.position, rig.flight.now_s - 0.1
    vehicle.change(velocity=(0.0, 10.0, 0.0), motion_measured_s=measured_s)
    north, east, down = guidance.away(vehicle.state, here)
    assert (north, down) == (0.0, 0.0) and east == pytest.approx(-10.0 * (0.1 + TICK_S / 2))
    vehicle.change(motion_measured_s=measured_s - 60.0)
    _, east, _ = guidance.away(vehicle.state, here)
    assert east == pytest.approx(-10.0 * EXTRAPOLATED_S)


def test_it_begins_with_the_vehicles_own_motion_where_that_is_another_one() -> None:
    """Far from its setpoint, also since its frame has moved; and while it is told nothing."""
    rig = stopping()
    guidance, vehicle = rig.flight.guidance, rig.vehicle
    assert vehicle.state is not None
    north, east, down = vehicle.state.motion.position
    away = (north, east + LAG_SHARE * rig.flight.profile.carrot_m + 0.1, down)
    vehicle.change(position=away, velocity=(0.0, 1.0, 0.0))
    assert guidance.departure is not None and guidance.departure.stop is guidance.stop
    assert guidance.departure.now.position == away and speed_mps(guidance) == 1.0
    guidance.forget_setpoint()
    assert guidance.departure is not None and guidance.departure.stop is None
    assert speed_mps(guidance) == 1.0
    guidance.hold()
    assert speed_mps(guidance) == 0.0
    vehicle.state = None
    assert guidance.departure is None


def test_a_vehicle_that_drifts_is_held_where_it_was_and_rises_meanwhile() -> None:
    """Before the task begins, for as long as an autopilot takes to say that it is in OFFBOARD."""
    rig = Rig(mission("F at(A)"))
    rig.vehicle.change(position=(0.0, 0.0, -1.0))
    rig.flight.guidance.hold_here()
    for number in range(1, 5):
        rig.vehicle.change(position=(0.1 * number, 0.0, -1.0 - 0.1 * number))
        rig.flight.guidance.hold_here()
        assert rig.vehicle.setpoint is not None
        assert rig.vehicle.setpoint.position == (0.0, 0.0, -1.0 - 0.1 * number)


def test_one_that_has_been_taken_further_is_held_where_it_is() -> None:
    rig = Rig(mission("F at(A)"))
    rig.vehicle.change(position=(0.0, 0.0, -2.0))
    rig.flight.guidance.hold_here()
    rig.vehicle.change(position=(HELD_M + 0.01, 0.0, -2.0))
    rig.flight.guidance.hold_here()
    assert rig.vehicle.setpoint is not None
    assert rig.vehicle.setpoint.position == (HELD_M + 0.01, 0.0, -2.0)
