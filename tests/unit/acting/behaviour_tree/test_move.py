"""The leaf that flies, by itself: when it sends what, when it ends, and what it goes round."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from leaves import a_rig, later, run, tick, walled_in
from py_trees.behaviour import Behaviour
from py_trees.common import Status
from rig import Rig
from synthetic import POSITIONS

from companion.acting.behaviour_tree.move import (
    ARRIVAL_M,
    ARRIVAL_TIMEOUT_S,
    MoveCommand,
)
from companion.acting.guidance import LAG_SHARE
from companion.flight_events.skills import RouteBlocked, RouteResponse
from companion.geometry import distance, moved
from companion.motion.grid import OccupancyGrid
from companion.motion.time_scaling import WAITS_SHARE
from companion.planning.flight_times import route_map
from companion.tick import TICK_S
from companion.vehicle.ports.setpoints import Setpoint, hold_at
from companion.vehicle_profile import VehicleProfile

QUAD = VehicleProfile()
LAG_M = LAG_SHARE * QUAD.carrot_m


def test_a_move_starts_where_the_vehicle_is_and_ends_at_the_place() -> None:
    """`c` of move_cmd(c, w) is always the present state, also off the place it is said to be."""
    rig = a_rig()
    rig.vehicle.change(position=(2.0, 1.0, -1.5))
    assert run(rig, MoveCommand(rig.flight, "A", None)) is Status.SUCCESS
    first, last = rig.vehicle.flown[0], rig.vehicle.flown[-1]
    assert first is not None and distance(first.position, (2.0, 1.0, -1.5)) < 1e-9
    assert last is not None and last.position == POSITIONS["A"]
    assert rig.vehicle.state is not None
    assert distance(rig.vehicle.state.motion.position, POSITIONS["A"]) < ARRIVAL_M


def test_a_move_sends_one_setpoint_per_tick_within_the_speed_limit() -> None:
    rig = a_rig()
    leaf = MoveCommand(rig.flight, "A", None)
    ticks = 0
    while tick(rig, leaf) is Status.RUNNING:
        ticks += 1
        assert len(rig.vehicle.flown) == ticks
    for setpoint in rig.vehicle.flown:
        assert setpoint is not None
        assert np.linalg.norm(setpoint.velocity) <= rig.mission.limits.speed_mps + 1e-9


def test_a_move_without_a_profile_holds_and_fails(monkeypatch: pytest.MonkeyPatch) -> None:
    """Ruckig may find none; the loop that sends setpoints must not end by it."""

    def find_none(*_: object) -> None:
        raise ArithmeticError("no profile")

    monkeypatch.setattr("companion.motion.trajectory.quickest", find_none)
    rig = a_rig()
    assert tick(rig, MoveCommand(rig.flight, "A", None)) is Status.FAILURE
    assert rig.vehicle.flown[-1] is not None and rig.vehicle.flown[-1].velocity == (0.0, 0.0, 0.0)


@pytest.mark.parametrize("why", ["no way", "no state"])
def test_without_a_route_a_move_fails(why: str) -> None:
    rig = a_rig()
    if why == "no way":
        rig.flight.routes = route_map(replace(rig.mission, grid=walled_in("A")))
    else:
        rig.vehicle.state = None
    leaf = MoveCommand(rig.flight, "A", None)
    assert tick(rig, leaf) is Status.FAILURE
    assert leaf.feedback_message == "no clear route to A"


def test_the_setpoint_waits_for_a_vehicle_that_falls_behind() -> None:
    """Otherwise it would run out of the gate's reach, and the gate would hold."""
    rig = a_rig()
    rig.vehicle.is_stuck = True
    leaf = MoveCommand(rig.flight, "A", None)
    for _ in range(200):
        assert tick(rig, leaf) is Status.RUNNING
    assert rig.vehicle.setpoint is not None and rig.vehicle.state is not None
    gap_m = distance(rig.vehicle.setpoint.position, rig.vehicle.state.motion.position)
    assert LAG_M <= gap_m <= WAITS_SHARE * QUAD.carrot_m
    rig.vehicle.is_stuck = False
    assert run(rig, leaf) is Status.SUCCESS


def test_the_setpoint_does_not_wait_for_a_vehicle_that_is_ahead() -> None:
    """As one is that brakes late. A setpoint that waited would stop, and leave it to overshoot."""
    rig = a_rig()
    leaf = MoveCommand(rig.flight, "A", None)
    for _ in range(20):
        tick(rig, leaf)
    assert rig.vehicle.setpoint is not None
    speed_mps = math.hypot(*rig.vehicle.setpoint.velocity)
    assert speed_mps > 0.5
    rig.vehicle.is_stuck = True
    ahead = moved(rig.vehicle.setpoint.position, rig.vehicle.setpoint.velocity, 1.2 / speed_mps)
    rig.vehicle.change(position=ahead)
    tick(rig, leaf)
    assert math.hypot(*rig.vehicle.setpoint.velocity) >= speed_mps


def test_a_vehicle_that_came_to_rest_far_away_begins_again_from_there() -> None:
    """The gate holds it where it is, so that waiting for it would be in vain."""
    rig = a_rig()
    leaf = MoveCommand(rig.flight, "A", None)
    for _ in range(20):
        tick(rig, leaf)
    assert rig.vehicle.state is not None
    north, east, down = rig.vehicle.state.motion.position
    rig.vehicle.is_stuck = True
    rig.vehicle.change(position=(north, east + 2.0, down))
    tick(rig, leaf)
    tick(rig, leaf)
    assert rig.vehicle.setpoint is not None
    assert distance(rig.vehicle.setpoint.position, rig.vehicle.state.motion.position) < LAG_M
    rig.vehicle.is_stuck = False
    assert run(rig, leaf) is Status.SUCCESS


def test_a_vehicle_that_is_pushed_back_for_ever_is_stuck() -> None:
    """It never lags behind for long: it begins anew from each place that it is pushed to."""
    rig = a_rig()
    leaf = MoveCommand(rig.flight, "A", None)
    for _ in range(20):
        tick(rig, leaf)
    rig.vehicle.is_stuck = True

    def pushed() -> Status:
        assert rig.vehicle.state is not None
        north, east, down = rig.vehicle.state.motion.position
        rig.vehicle.change(position=(north - 0.1 * TICK_S, east, down))
        return tick(rig, leaf)

    ticks = 0
    while pushed() is Status.RUNNING:
        ticks += 1
    assert leaf.feedback_message == "stuck on the way to A"
    assert ARRIVAL_TIMEOUT_S < ticks * TICK_S < 3 * ARRIVAL_TIMEOUT_S


def test_a_vehicle_that_settles_beside_the_place_has_not_arrived() -> None:
    rig = a_rig()
    rig.vehicle.drift = (0.0, 0.5, 0.0)
    leaf = MoveCommand(rig.flight, "A", None)
    assert run(rig, leaf) is Status.FAILURE
    assert leaf.feedback_message == "still 0.5 m from A"
    flown_s = len(rig.vehicle.flown) * TICK_S
    assert ARRIVAL_TIMEOUT_S < flown_s < ARRIVAL_TIMEOUT_S + 6.0


def test_a_vehicle_that_settles_near_enough_has() -> None:
    rig = a_rig()
    rig.vehicle.drift = (0.0, 0.9 * ARRIVAL_M, 0.0)
    assert run(rig, MoveCommand(rig.flight, "A", None)) is Status.SUCCESS


def test_a_move_ends_at_its_timeout_and_holds() -> None:
    rig = a_rig()
    start_s = later(rig)
    leaf = MoveCommand(rig.flight, "A", timeout_s=1.0)
    assert run(rig, leaf) is Status.FAILURE
    assert leaf.feedback_message == "not there after 1 s"
    assert rig.flight.now_s - start_s == pytest.approx(1.0, abs=3 * TICK_S)
    come_to_rest(rig)


def test_an_interrupted_move_comes_to_rest_along_its_path_without_a_jump() -> None:
    rig = a_rig()
    leaf = MoveCommand(rig.flight, "A", None)
    for _ in range(40):
        tick(rig, leaf)
    moving, flown = rig.vehicle.setpoint, len(rig.vehicle.flown)
    assert moving is not None and moving.velocity != (0.0, 0.0, 0.0)
    leaf.stop(Status.INVALID)
    held = come_to_rest(rig)
    assert 0.5 < distance(held.position, moving.position) < 2.0
    assert greatest_acceleration_mps2(setpoints_since(rig, flown - 1)) <= QUAD.acceleration_mps2
    assert held == hold_at(held.position, held.yaw_rad)


def test_a_move_that_is_interrupted_goes_on_without_a_jump() -> None:
    rig = a_rig()
    first, second = MoveCommand(rig.flight, "A", None), MoveCommand(rig.flight, "A", None)
    for _ in range(40):
        tick(rig, first)
    first.stop(Status.INVALID)
    for _ in range(5):
        rig.pass_time()
        rig.flight.guidance.brake()
    assert run(rig, second) is Status.SUCCESS
    since = setpoints_since(rig, 0)
    assert greatest_acceleration_mps2(since) <= QUAD.acceleration_mps2 + 1e-6
    assert min(np.linalg.norm(s.velocity) for s in since[40:60]) > 1.0


def test_a_move_that_has_ended_is_not_held_again() -> None:
    rig = a_rig()
    leaf = MoveCommand(rig.flight, "A", None)
    run(rig, leaf)
    flown = len(rig.vehicle.flown)
    leaf.stop(Status.INVALID)
    assert len(rig.vehicle.flown) == flown


# -- a map that changes on the way -----------------------------------------------------------------


def crate(south: float, west: float, north: float, east: float) -> OccupancyGrid:
    """The room, 10 m x 10 m from (-2, -2) on, with a box in it; metres north and east."""
    edges = -2.0 + 0.1 * (np.arange(100) + 0.5)
    rows, cols = (edges > south) & (edges < north), (edges > west) & (edges < east)
    return OccupancyGrid(np.outer(rows, cols), 0.1, (-2.0, -2.0))


NOTHING = crate(0, 0, 0, 0)


def a_finer_rig() -> Rig:
    return a_rig(grid=NOTHING)


def fly_until(rig: Rig, leaf: Behaviour, north_m: float) -> None:
    """Ticks until the vehicle has come so far north, on its way from H to A."""
    assert rig.vehicle.state is not None
    while rig.vehicle.state.motion.position[0] < north_m:
        assert tick(rig, leaf) is Status.RUNNING


def setpoints_since(rig: Rig, flown: int) -> list[Setpoint]:
    return [s for s in rig.vehicle.flown[flown:] if s is not None]


def responses(rig: Rig) -> list[RouteResponse]:
    """What was done about blocked ways to A; nothing else was reported."""
    blocked = [stamped.event for stamped in rig.flight.reports]
    assert all(isinstance(event, RouteBlocked) and event.place == "A" for event in blocked)
    return [event.response for event in blocked]  # type: ignore[attr-defined]


def greatest_acceleration_mps2(setpoints: list[Setpoint]) -> float:
    """Of the velocity that the vehicle is told; one setpoint a tick, or two at a change of plan."""
    changes = np.diff([s.velocity for s in setpoints], axis=0)
    return float(np.linalg.norm(changes, axis=1).max()) / TICK_S


def come_to_rest(rig: Rig) -> Setpoint:
    """Ticks of a flight in which nothing acts."""
    for _ in range(60):
        rig.pass_time()
        rig.flight.guidance.brake()
    assert rig.vehicle.setpoint is not None
    assert rig.vehicle.setpoint.velocity == (0.0, 0.0, 0.0)
    return rig.vehicle.setpoint


@pytest.mark.parametrize("so_far_m", [1.0, 2.0, 2.8])
def test_a_crate_on_the_way_is_flown_round_without_a_stop(so_far_m: float) -> None:
    rig = a_finer_rig()
    leaf = MoveCommand(rig.flight, "A", None)
    fly_until(rig, leaf, so_far_m)
    flown = len(rig.vehicle.flown)
    grid = crate(so_far_m + 2.2, -0.3, so_far_m + 2.5, 0.3)
    rig.flight.routes.see(grid)
    assert run(rig, leaf) is Status.SUCCESS
    assert responses(rig) == [RouteResponse.ANOTHER_ROUTE]
    since = setpoints_since(rig, flown)
    assert min(grid.clearance_m(s.position[:2]) for s in since) >= 0.6 - 0.1  # a cell's diagonal
    assert min(np.linalg.norm(s.velocity) for s in since[:10]) > 0.2
    gaps = [distance(a.position, b.position) for a, b in pairwise(rig.vehicle.flown)]  # type: ignore[union-attr]
    assert max(gaps) <= rig.mission.limits.speed_mps * TICK_S + 1e-9  # no jump, also not there
    assert greatest_acceleration_mps2(setpoints_since(rig, 0)) <= QUAD.acceleration_mps2 + 1e-6


def test_without_a_way_it_comes_to_a_stop_before_the_wall_and_fails_there() -> None:
    """It takes v^2 / 2a + v a / 2j, and no setpoint is nearer to the wall than its end."""
    rig = a_finer_rig()
    leaf = MoveCommand(rig.flight, "A", None)
    fly_until(rig, leaf, 3.0)
    last = rig.vehicle.setpoint
    assert last is not None
    flown = len(rig.vehicle.flown)
    grid = crate(4.7, -2.0, 4.9, 8.0)
    rig.flight.routes.see(grid)
    assert run(rig, leaf) is Status.FAILURE
    assert leaf.feedback_message == "no clear route to A"
    assert responses(rig) == [RouteResponse.STOPPING, RouteResponse.NO_ROUTE]
    since = setpoints_since(rig, flown)
    speed_mps = float(np.linalg.norm(last.velocity))
    braking_m = speed_mps**2 / (2 * QUAD.braking_mps2) + speed_mps * QUAD.braking_mps2 / (
        2 * QUAD.jerk_mps3
    )
    way_m = max(s.position[0] for s in since) - last.position[0]
    assert braking_m <= way_m <= braking_m + 2 * speed_mps * TICK_S
    assert since[-1].velocity == (0.0, 0.0, 0.0)
    assert greatest_acceleration_mps2(setpoints_since(rig, 0)) <= QUAD.braking_mps2 + 1e-6
    assert grid.clearance_m(since[-1].position[:2]) > 0.35


def test_from_a_stop_it_goes_on_where_another_way_is_left() -> None:
    """A wall so near that no turn at speed leads round it."""
    rig = a_finer_rig()
    leaf = MoveCommand(rig.flight, "A", None)
    fly_until(rig, leaf, 3.0)
    rig.flight.routes.see(crate(4.6, -2.0, 4.8, 3.0))
    assert run(rig, leaf) is Status.SUCCESS
    assert responses(rig) == [RouteResponse.STOPPING, RouteResponse.ANOTHER_ROUTE]


def test_a_way_round_that_takes_several_ticks_to_find_needs_no_stop(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The obstacle is far enough ahead: the vehicle flies on towards it meanwhile."""
    monkeypatch.setattr("companion.acting.behaviour_tree.move.CELLS_PER_TICK", 1500)
    rig = a_finer_rig()
    leaf = MoveCommand(rig.flight, "A", None)
    fly_until(rig, leaf, 1.0)
    grid = crate(4.2, -0.3, 4.5, 0.3)
    rig.flight.routes.see(grid)
    assert tick(rig, leaf) is tick(rig, leaf) is Status.RUNNING
    assert responses(rig) == []
    assert run(rig, leaf) is Status.SUCCESS
    assert responses(rig) == [RouteResponse.ANOTHER_ROUTE]
    assert min(grid.clearance_m(s.position[:2]) for s in setpoints_since(rig, 0)) >= 0.6 - 0.1
    assert greatest_acceleration_mps2(setpoints_since(rig, 0)) <= QUAD.acceleration_mps2 + 1e-6


def test_a_way_that_is_not_found_in_time_is_waited_for_at_rest(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("companion.acting.behaviour_tree.move.CELLS_PER_TICK", 1)
    rig = a_finer_rig()
    leaf = MoveCommand(rig.flight, "A", None)
    fly_until(rig, leaf, 1.0)
    wall = crate(4.0, -2.0, 4.2, 3.0)
    rig.flight.routes.see(wall)
    assert run(rig, leaf) is Status.SUCCESS
    assert responses(rig) == [RouteResponse.STOPPING, RouteResponse.ANOTHER_ROUTE]
    assert min(wall.clearance_m(s.position[:2]) for s in setpoints_since(rig, 0)) >= 0.6 - 0.1


def test_a_move_waits_for_its_way_and_holds(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("companion.acting.behaviour_tree.move.CELLS_PER_TICK", 500)
    rig = a_finer_rig()
    rig.flight.routes.see(crate(2.0, -0.5, 3.0, 0.5))
    rig.flight.routes.aim("A", (5.8, 0.1, -2.0))
    leaf = MoveCommand(rig.flight, "A", None)
    for _ in range(3):
        assert tick(rig, leaf) is Status.RUNNING
    assert set(rig.vehicle.flown) == {hold_at(POSITIONS["H"], 0.0)}
    assert run(rig, leaf) is Status.SUCCESS
    assert rig.vehicle.flown[-1] is not None
    assert rig.vehicle.flown[-1].position == (5.8, 0.1, -2.0)


def test_a_change_elsewhere_leaves_the_trajectory_as_it_is() -> None:
    changed, left = a_finer_rig(), a_finer_rig()
    for rig in (changed, left):
        leaf = MoveCommand(rig.flight, "A", None)
        fly_until(rig, leaf, 2.0)
        if rig is changed:
            rig.flight.routes.see(crate(3.0, 1.0, 4.0, 2.0))
        assert run(rig, leaf) is Status.SUCCESS
    assert changed.vehicle.flown == left.vehicle.flown
    assert changed.flight.reports == []
