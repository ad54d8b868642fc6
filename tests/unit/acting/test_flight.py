"""What all behaviours of a flight share: its reports, and how a flight begins."""

from __future__ import annotations

import math

from leaves import tick
from py_trees.common import Status
from rig import Rig
from synthetic import mission

from companion.acting.behaviour_tree.move import MoveCommand
from companion.acting.flight import HELD_M, LAG_SHARE, Flight
from companion.flight_events.event import Stamped
from companion.flight_events.sortie import ControlRegained, StopRequested


def test_a_report_has_the_time_of_its_tick_and_one_from_beside_the_flight_its_own() -> None:
    flight = Rig(mission("F at(A)")).flight
    flight.now_s = 2.0
    flight.report(StopRequested())
    flight.add_report(Stamped(1.5, ControlRegained()))
    assert flight.reports == [Stamped(2.0, StopRequested()), Stamped(1.5, ControlRegained())]


def test_what_has_happened_is_collected_once() -> None:
    flight = Rig(mission("F at(A)")).flight
    flight.report(StopRequested())
    assert flight.collect_reports() == [Stamped(0.0, StopRequested())]
    assert flight.collect_reports() == []


def stopping() -> Rig:
    """A vehicle that has given up a flight."""
    rig = Rig(mission("F at(A)"))
    leaf = MoveCommand(rig.flight, "A", None)
    for _ in range(40):
        tick(rig, leaf)
    leaf.stop(Status.INVALID)
    return rig


def speed_mps(flight: Flight) -> float:
    assert flight.departure is not None
    return math.hypot(*flight.departure.now.velocity)


def test_a_flight_begins_with_the_motion_that_the_vehicle_is_told() -> None:
    rig = stopping()
    flight, vehicle = rig.flight, rig.vehicle
    told = flight.departure
    assert told is not None and flight.setpoint is not None and told.stop is flight.stop
    assert told.now.position == flight.setpoint.position and speed_mps(flight) > 1.5
    vehicle.change(velocity=(0.0, 1.0, 0.0))
    assert flight.departure == told
    rest, left_s = told.rest
    while flight.stop is not None:
        rig.pass_time()
        flight.brake()
    flight.hold()
    assert flight.departure is not None and flight.departure.now.position == rest
    assert speed_mps(flight) == 0.0 and 1.0 < left_s < 2.0


def test_it_begins_with_the_vehicles_own_motion_where_that_is_another_one() -> None:
    """Far from its setpoint, also since its frame has moved; and while it is told nothing."""
    flight, vehicle = (rig := stopping()).flight, rig.vehicle
    assert vehicle.state is not None
    north, east, down = vehicle.state.position
    away = (north, east + LAG_SHARE * flight.profile.carrot_m + 0.1, down)
    vehicle.change(position=away, velocity=(0.0, 1.0, 0.0))
    assert flight.departure is not None and flight.departure.stop is flight.stop
    assert flight.departure.now.position == away and speed_mps(flight) == 1.0
    flight.forget_setpoint()
    assert flight.departure is not None and flight.departure.stop is None
    assert speed_mps(flight) == 1.0
    flight.hold()
    assert speed_mps(flight) == 0.0
    vehicle.state = None
    assert flight.departure is None


def test_a_vehicle_that_drifts_is_held_where_it_was_and_rises_meanwhile() -> None:
    """Before the task begins, for as long as an autopilot takes to say that it is in OFFBOARD."""
    rig = Rig(mission("F at(A)"))
    rig.vehicle.change(position=(0.0, 0.0, -1.0))
    rig.flight.hold_here()
    for number in range(1, 5):
        rig.vehicle.change(position=(0.1 * number, 0.0, -1.0 - 0.1 * number))
        rig.flight.hold_here()
        assert rig.vehicle.setpoint is not None
        assert rig.vehicle.setpoint.position == (0.0, 0.0, -1.0 - 0.1 * number)


def test_one_that_has_been_taken_further_is_held_where_it_is() -> None:
    rig = Rig(mission("F at(A)"))
    rig.vehicle.change(position=(0.0, 0.0, -2.0))
    rig.flight.hold_here()
    rig.vehicle.change(position=(HELD_M + 0.01, 0.0, -2.0))
    rig.flight.hold_here()
    assert rig.vehicle.setpoint is not None
    assert rig.vehicle.setpoint.position == (HELD_M + 0.01, 0.0, -2.0)
