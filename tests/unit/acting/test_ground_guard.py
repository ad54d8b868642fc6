"""The vehicle is kept off what is below it by its setpoints, where a range finder looks down."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from fakes import on_hold
from hypothesis import given
from hypothesis import strategies as st
from states import changed

from companion.acting.ground_guard import CLEAR_AGAIN_M, RISE_M, GroundGuard
from companion.flight_events.skills import GroundNear
from companion.geometry import Ned
from companion.motion.grid import LowWalls, OccupancyGrid
from companion.motion.layered_routes import LayeredRoutes
from companion.motion.profile import SpeedLimits
from companion.motion.region import Disc
from companion.motion.routes import PlaceRegion
from companion.vehicle.ports.setpoints import Setpoint, hold_at
from companion.vehicle.ports.state import Mode, VehicleState
from companion.vehicle_profile import VehicleProfile

PROFILE = VehicleProfile()
ASKED_M, TOP_M = PROFILE.clearance_m, 10.0
HERE: Ned = (3.0, 3.0, -2.0)


def guard(wall_m: float = 0.0) -> GroundGuard:
    """Over an open field, or over a low wall that covers it."""
    empty = np.zeros((60, 60), dtype=np.bool_)
    low = LowWalls(np.full((60, 60), wall_m)) if wall_m else None
    routes = LayeredRoutes(
        OccupancyGrid(empty, 0.1, (0.0, 0.0), low=low),
        {"M": PlaceRegion(HERE, Disc(0.5), is_exclusive=True)},
        ((0.0, 0.0), (0.0, 6.0), (6.0, 6.0), (6.0, 0.0)),
        PROFILE.clearance_m,
        SpeedLimits(2.0, 2.0, 8.0),
    )
    return GroundGuard(routes, PROFILE, TOP_M)


def flying(below_m: float | None, position: Ned = HERE, mode: Mode = Mode.OFFBOARD) -> VehicleState:
    return changed(on_hold(0.0), position=position, mode=mode, below_m=below_m)


def told(position: Ned = HERE, down_mps: float = 0.0) -> Setpoint:
    return replace(hold_at(position, 0.0), velocity=(1.0, 0.0, down_mps))


def up_m(setpoint: Setpoint) -> float:
    return -setpoint.position[2]


def test_a_vehicle_lower_than_it_takes_itself_for_is_sent_up_and_that_is_told_once() -> None:
    kept, low_m = guard(), ASKED_M - 0.1
    sent, news = kept.kept_off(told(down_mps=0.5), flying(low_m))
    assert news == GroundNear(round(low_m, 2), 2.0)
    assert up_m(sent) == pytest.approx(2.0 + 0.1 + RISE_M)
    assert sent.position[:2] == HERE[:2] and sent.velocity == (1.0, 0.0, 0.0)
    risen: Ned = (3.0, 3.0, -2.0 - 0.1 - RISE_M)
    sent, news = kept.kept_off(told(), flying(low_m + 0.1 + RISE_M, risen))
    assert news is None and sent.position == risen, "it stays up there"


def test_it_goes_down_again_where_the_setpoint_leads_clear_of_the_ground() -> None:
    kept = guard()
    assert kept.kept_off(told(), flying(ASKED_M - 0.01))[1] is not None
    for above_m, is_lifted in ((CLEAR_AGAIN_M - 0.01, True), (CLEAR_AGAIN_M + 0.01, False)):
        sent, _ = kept.kept_off(told(), flying(ASKED_M + above_m))
        assert (up_m(sent) > 2.0) is is_lifted
    assert kept.kept_off(told(), flying(ASKED_M + 0.01))[0] == told()
    assert kept.kept_off(told(), flying(ASKED_M - 0.01))[1] is not None, "told anew"


def test_a_descent_ends_where_the_ground_is_however_high_the_vehicle_still_is() -> None:
    """At 3 m by its altitude, and truly 1.5 m lower; sent to 1.9 m, so to 0.4 m."""
    sent, _ = guard().kept_off(told((3.0, 3.0, -1.9)), flying(1.5, (3.0, 3.0, -3.0)))
    true_m = 1.5 + up_m(sent) - 3.0
    assert true_m == pytest.approx(ASKED_M + RISE_M)


@pytest.mark.parametrize("mode", sorted(set(Mode) - {Mode.OFFBOARD}))
def test_no_other_mode_is_meddled_with(mode: Mode) -> None:
    assert guard().kept_off(told(), flying(0.1, mode=mode)) == (told(), None)


@pytest.mark.parametrize("state", [None, flying(None), flying(math.inf), flying(2.0)])
def test_what_is_not_known_or_far_enough_lifts_nothing(state: VehicleState | None) -> None:
    assert guard().kept_off(told(), state) == (told(), None)


def test_while_the_range_finder_is_silent_what_was_lifted_stays_so() -> None:
    kept = guard()
    lifted, _ = kept.kept_off(told(), flying(ASKED_M - 0.1))
    assert kept.kept_off(told(), flying(None)) == (lifted, None)
    assert kept.kept_off(told(), flying(ASKED_M - 0.1))[1] is None, "it was told"
    assert kept.kept_off(told(), flying(None, mode=Mode.LOITER)) == (told(), None)
    assert kept.kept_off(told(), flying(None)) == (told(), None), "the autopilot flew meanwhile"


def test_the_way_down_to_a_marker_is_not_lifted() -> None:
    assert guard().kept_off(told(), flying(0.1), is_landing=True) == (told(), None)


def test_low_flights_and_flights_over_low_walls_are_as_the_mission_wants_them() -> None:
    low: Ned = (3.0, 3.0, -0.8)
    assert guard().kept_off(told(low), flying(0.45, low)) == (told(low), None)
    assert guard().kept_off(told(low), flying(0.35, low))[1] is not None
    over: Ned = (3.0, 3.0, -3.7)
    assert guard(3.0).kept_off(told(over), flying(0.4, over)) == (told(over), None)
    assert guard(3.0).kept_off(told(over), flying(0.3, over))[1] is not None


heights = st.floats(0.0, 12.0)


@given(
    vehicle_up_m=heights,
    told_up_m=heights,
    below_m=st.floats(0.0, 15.0),
    beside_m=st.floats(-2.0, 2.0),
    wall_m=st.sampled_from([0.0, 1.0, 3.0]),
)
def test_it_only_lifts_and_no_further_than_the_gate_lets_out(
    vehicle_up_m: float, told_up_m: float, below_m: float, beside_m: float, wall_m: float
) -> None:
    here, there = (3.0, 3.0, -vehicle_up_m), (3.0, 3.0 + beside_m, -told_up_m)
    sent, news = guard(wall_m).kept_off(told(there), flying(below_m, here))
    assert sent.position[:2] == there[:2] and up_m(sent) >= told_up_m
    if sent.position != there:
        assert news is not None
        assert math.dist(sent.position, here) <= max(PROFILE.carrot_m, math.dist(there, here))
        assert up_m(sent) <= max(TOP_M, vehicle_up_m)
