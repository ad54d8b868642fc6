"""Symbols: which waypoint stands for a place, who said so, and what is tried after a failure."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from rig import Rig
from synthetic import POSITIONS, mission

from companion.acting.symbols import INSIDE_M, REFUSED_S, SAME_M, SAMPLES, Symbols, Value, around
from companion.flight_events.skills import PlaceReached, SymbolMoved
from companion.geometry import Ned, distance, horizontal_distance
from companion.mission.places import Place
from companion.motion.grid import OccupancyGrid
from companion.motion.layered_routes import LayeredRoutes
from companion.motion.profile import SpeedLimits
from companion.motion.region import Disc
from companion.motion.routes import PlaceRegion
from companion.slices import InSlices

HOME: Ned = (0.0, 0.0, -2.0)
WIDE = Place("A", (5.0, 0.0, -2.0), Disc(2.0))
LIMITS = SpeedLimits(2.0, 2.0, 8.0)
FENCE = ((-9.0, -9.0), (-9.0, 9.0), (9.0, 9.0), (9.0, -9.0))


def world(*blocked: tuple[float, float]) -> tuple[Symbols, LayeredRoutes]:
    """20 m by 20 m with 0.4 m boxes, and one wide place."""
    routes = LayeredRoutes(
        grid(*blocked), {"A": PlaceRegion(WIDE.position, WIDE.region, False)}, FENCE, 0.6, LIMITS
    )
    return Symbols({"A": WIDE}, routes), routes


def grounded(symbols: Symbols, now_s: float) -> bool:
    """Whether A has a waypoint."""
    return symbols.ground("A", HOME, now_s)


def grid(*blocked: tuple[float, float]) -> OccupancyGrid:
    occupied = np.zeros((100, 100), dtype=np.bool_)
    for north, east in blocked:
        row, col = int((north + 10) / 0.2), int((east + 10) / 0.2)
        occupied[row - 1 : row + 1, col - 1 : col + 1] = True
    return OccupancyGrid(occupied, 0.2, (-10.0, -10.0))


@given(st.floats(0.31, 20.0))
def test_samples_lie_in_the_region_and_apart(radius_m: float) -> None:
    place = Place("A", WIDE.position, Disc(radius_m))
    samples = list(around(place, Value(place.position, "", 0.0)))
    away = [horizontal_distance(sample, place.position) for sample in samples]
    assert len(samples) == SAMPLES
    assert max(away) <= radius_m - INSIDE_M + 1e-9
    assert away == sorted(away)
    gaps = [distance(a, b) for i, a in enumerate(samples) for b in samples[:i]]
    assert min(gaps) > 0.5 * max(away) / math.sqrt(SAMPLES)


def test_what_can_be_flown_to_stays_as_it_is() -> None:
    symbols, _ = world()
    before = symbols["A"]
    assert grounded(symbols, 3.0)
    assert symbols["A"] is before == Value(WIDE.position, "the mission", 0.0)


def test_an_obstacle_in_the_place_moves_its_waypoint_within_the_region() -> None:
    symbols, routes = world((5.0, 0.0))
    assert grounded(symbols, 3.0)
    value = symbols["A"]
    assert (value.source, value.stamp_s) == ("samples of the region", 3.0)
    assert horizontal_distance(value.position, WIDE.position) <= WIDE.inner_m - INSIDE_M
    assert routes.is_free(value.position)
    route = routes.route(HOME, "A")
    assert route is not None and tuple(route.waypoints[-1]) == value.position


@pytest.mark.parametrize("added_m", [0.0, 0.3, 0.6, 2.0])
def test_the_waypoint_keeps_what_routes_keep_where_the_region_has_the_room(added_m: float) -> None:
    symbols, routes = world((5.0, 0.0))
    routes.add_clearance(added_m)
    assert grounded(symbols, 3.0)
    chosen, value = symbols["A"].position, Value(WIDE.position, "", 0.0)
    rooms = [min(routes.kept_m, grid((5.0, 0.0)).clearance_m(p[:2])) for p in around(WIDE, value)]
    assert grid((5.0, 0.0)).clearance_m(chosen[:2]) >= max(rooms)
    if added_m <= 0.6:
        assert max(rooms) == routes.kept_m
        nearest = [distance(p, WIDE.position) for p in around(WIDE, value)][rooms.index(max(rooms))]
        assert distance(chosen, WIDE.position) == nearest


def test_after_a_failure_another_waypoint_is_taken_and_the_first_one_again_later() -> None:
    symbols, _ = world()
    symbols.refuse("A", 1.0)
    assert grounded(symbols, 2.0)
    second = symbols["A"].position
    assert distance(second, WIDE.position) >= SAME_M
    symbols.refuse("A", 3.0)
    assert grounded(symbols, 4.0)
    assert min(distance(symbols["A"].position, p) for p in (second, WIDE.position)) >= SAME_M
    symbols.refuse("A", 5.0)
    assert grounded(symbols, 5.0 + REFUSED_S - 1.0)
    assert symbols["A"].position == WIDE.position  # its refusal is over, the others' are not


def test_a_region_without_a_free_waypoint_cannot_be_grounded_and_stays() -> None:
    everywhere = [(n / 2, e / 2) for n in range(4, 17) for e in range(-6, 7)]
    symbols, routes = world(*everywhere)
    before = symbols["A"]
    assert not grounded(symbols, 1.0)
    assert symbols["A"] is before
    assert routes.distance_m(HOME, "A") == math.inf


def test_a_waypoint_beyond_a_wall_is_not_taken() -> None:
    """Free, but no way leads there: the test of reachability refuses what the other one lets by."""
    wall = [(7.0, e / 5) for e in range(-50, 50)]
    place = Place("A", (7.0, 0.0, -2.0), Disc(2.5))
    routes = LayeredRoutes(
        grid(*wall), {"A": PlaceRegion(place.position, place.region, False)}, FENCE, 0.6, LIMITS
    )
    symbols = Symbols({"A": place}, routes)
    assert grounded(symbols, 1.0)
    assert symbols["A"].position[0] < 7.0


def test_a_map_that_changes_moves_only_what_it_takes_away() -> None:
    symbols, routes = world()
    assert list(symbols.follow_map(HOME, 1.0)) == []
    routes.see(grid((5.0, 0.0)))
    assert list(symbols.follow_map(HOME, 2.0)) == ["A"]
    routes.see(grid())
    assert list(symbols.follow_map(HOME, 3.0)) == []  # it stays where it is now


def in_small_slices(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("companion.acting.symbols.CELLS_PER_TICK", 500)
    monkeypatch.setattr("companion.slices.SLICE_US", 100)


def test_a_choice_is_made_in_slices(monkeypatch: pytest.MonkeyPatch) -> None:
    """The same one as at once; if it is given up, routes lead to the waypoint of before."""
    at_once, _ = world((5.0, 0.0))
    assert grounded(at_once, 3.0)
    in_small_slices(monkeypatch)
    symbols, routes = world((5.0, 0.0))
    given_up, choice = (InSlices(lambda: grounded(symbols, 3.0)) for _ in range(2))
    assert not given_up.step()
    given_up.abandon()
    assert routes.goal("A") == symbols["A"].position == WIDE.position
    ticks = 1
    while not choice.step():
        ticks += 1
    assert choice.result and ticks > 2
    assert routes.goal("A") == symbols["A"].position == at_once["A"].position


def test_two_choices_at_a_time_end_as_one(monkeypatch: pytest.MonkeyPatch) -> None:
    in_small_slices(monkeypatch)
    symbols, routes = world((5.0, 0.0))
    choices = [InSlices(lambda: grounded(symbols, 3.0)) for _ in range(2)]
    while not all([choice.step() for choice in choices]):
        pass
    assert all(choice.result for choice in choices)
    assert routes.goal("A") == symbols["A"].position != WIDE.position


# -- in flight -------------------------------------------------------------------------------------


def test_a_try_that_fails_is_followed_by_another_waypoint() -> None:
    rig = Rig(mission("F at(A)")).begin()
    rig.tick()
    rig.vehicle.is_stuck = True
    rig.run(lambda: bool(rig.of(SymbolMoved, place="A")), 200.0)
    rig.vehicle.is_stuck = False
    rig.run_until(PlaceReached, place="A")
    assert rig.vehicle.state is not None
    gap_m = horizontal_distance(rig.vehicle.state.motion.position, POSITIONS["A"])
    assert 0.0 < gap_m <= rig.mission.places["A"].inner_m
    assert rig.executive.reports.replans == 0


@pytest.mark.parametrize("name", ["A", "B"])
def test_the_planner_s_costs_follow_the_waypoint(name: str) -> None:
    rig = Rig(mission("F at(A) & F at(B)"))
    far: Ned = (*(c + 0.75 for c in POSITIONS[name][:2]), -2.0)  # type: ignore[assignment]
    before = rig.flight.routes.distance_m((0.0, 0.0, -2.0), name)
    rig.flight.routes.aim(name, far)
    assert rig.flight.routes.distance_m((0.0, 0.0, -2.0), name) > before
