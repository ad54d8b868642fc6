"""A plan reckons a flight that begins in motion as `move_cmd` flies it."""

from __future__ import annotations

import math
from itertools import pairwise

import pytest
from drawn import drawn
from hypothesis import assume, given
from hypothesis import strategies as st
from leaves import a_rig, tick
from py_trees.common import Status
from rig import Rig
from synthetic import POSITIONS

from companion.acting.behaviour_tree.move import MoveCommand
from companion.motion.departure import SLOW_MPS, at_rest
from companion.planning.flown_routes import ARRIVAL_S, FlownRoutes
from companion.tick import TICK_S

SEEN_S = 4 * TICK_S
"""The first and the last tick of a flight, and that in which a turn has become straight."""
places, along = st.sampled_from("HAB"), st.floats(-0.4, 6.4)


@pytest.fixture(scope="module")
def rig() -> Rig:
    return a_rig()


def reckoned_s(rig: Rig, place: str) -> float:
    departure = rig.flight.guidance.departure
    assert departure is not None
    flown_routes = FlownRoutes(rig.flight.routes)
    return flown_routes.departure_s(departure, place, rig.speed_limit.target) - ARRIVAL_S


def flown_s(rig: Rig, leaf: MoveCommand) -> float:
    """From this tick to the one in which the vehicle is there."""
    begin_s = rig.flight.now_s
    leaf.tick_once()
    while leaf.status is Status.RUNNING:
        assert rig.flight.now_s < begin_s + 60
        tick(rig, leaf)
    assert leaf.status is Status.SUCCESS
    return rig.flight.now_s - begin_s


def give_up(rig: Rig, first: str, second: str, ticks: int, later: int) -> None:
    """A flight from one place to another ends after some ticks, and its stop goes on for others."""
    rig.flight.guidance.forget_setpoint()
    rig.vehicle.change(position=POSITIONS[first], velocity=(0.0, 0.0, 0.0))
    leaf = MoveCommand(rig.flight, second, None)
    for _ in range(ticks):
        tick(rig, leaf)
    leaf.stop(Status.INVALID)
    for _ in range(later):
        rig.pass_time()
        rig.flight.guidance.brake()


@drawn(30)
@given(along, along, st.floats(0, 2), st.floats(-math.pi, math.pi), places)
def test_from_any_motion(
    rig: Rig, north: float, east: float, mps: float, course: float, place: str
) -> None:
    """The vehicle's own motion, where it is told nothing yet."""
    velocity = (mps * math.cos(course), mps * math.sin(course), 0.0)
    rig.flight.guidance.forget_setpoint()
    rig.vehicle.change(position=(north, east, -2.0), velocity=velocity)
    reckoned = reckoned_s(rig, place)
    assert flown_s(rig, MoveCommand(rig.flight, place, None)) == pytest.approx(reckoned, abs=SEEN_S)


@drawn(30)
@given(places, places, st.integers(1, 200), st.integers(0, 20), places)
def test_from_a_flight_that_is_given_up(
    rig: Rig, first: str, second: str, ticks: int, later: int, place: str
) -> None:
    """In any moment of it, and of the stop that follows."""
    assume(first != second)
    give_up(rig, first, second, ticks, later)
    reckoned = reckoned_s(rig, place)
    assert flown_s(rig, MoveCommand(rig.flight, place, None)) == pytest.approx(reckoned, abs=SEEN_S)


def test_at_rest_it_is_the_leg_from_there(rig: Rig) -> None:
    flown_routes, limits = FlownRoutes(rig.flight.routes), rig.speed_limit.target
    for start in ((3.0, 1.0, -2.0), POSITIONS["B"]):
        assert flown_routes.departure_s(at_rest(start), "A", limits) == flown_routes.flight_s(
            start, "A", limits
        )


def test_to_turn_back_takes_the_way_to_a_stop_and_back(rig: Rig) -> None:
    rig.flight.guidance.forget_setpoint()
    rig.vehicle.change(position=(3.0, 0.0, -2.0), velocity=(2.0, 0.0, 0.0))
    ahead, back = reckoned_s(rig, "A"), reckoned_s(rig, "H")
    rig.vehicle.change(velocity=(0.9 * SLOW_MPS, 0.0, 0.0))
    rest = reckoned_s(rig, "H")
    assert ahead < rest - 0.3 < rest + 1.5 < back


def test_a_flight_that_is_given_up_just_before_its_end_comes_to_rest_there(rig: Rig) -> None:
    """It brakes harder than a change of plan may: a route from there would lead backwards."""
    give_up(rig, "H", "A", 61, 20)
    flown = len(rig.vehicle.flown) - 1
    flown_s(rig, MoveCommand(rig.flight, "B", None))
    told = [setpoint.position for setpoint in rig.vehicle.flown[flown:] if setpoint is not None]
    assert max(math.dist(a, b) for a, b in pairwise(told)) < 2.01 * TICK_S
