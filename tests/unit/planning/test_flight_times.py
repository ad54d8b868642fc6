"""Routes of a mission, and what a flight between two places costs."""

from __future__ import annotations

import math
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from synthetic import POSITIONS, mission

from companion.errors import MissionError
from companion.ltl.parser import parse_line
from companion.mission.loader import load_mission
from companion.mission.places import Place
from companion.motion.departure import Departure, at_rest
from companion.motion.region import Disc
from companion.motion.trajectory import Trajectory
from companion.planning.flight_times import flight_times, given_times, route_map
from companion.planning.flown_routes import ARRIVAL_S, FlownRoutes
from companion.vehicle_profile import VehicleProfile

QUAD = VehicleProfile()
MISSIONS = Path(__file__).parents[3] / "missions"


def test_home_is_where_the_mission_begins() -> None:
    asked = mission("F at(H)", initially=["at(B)", "loaded"])
    assert asked.home.name == "B"


def test_only_places_of_the_task_are_not_crossed_by_chance() -> None:
    """C, A and the middle of the room: M is in the way only if the task mentions it."""
    straight = math.hypot(6.0, 6.0)
    for task, is_in_the_way in (("F at(A)", False), ("F at(A) & G !at(M)", True)):
        asked = mission(task, places="HAC")
        middle = Place("M", (3.0, 3.0, -2.0), Disc(1.0))
        routes = route_map(replace(asked, places={**asked.places, "M": middle}))
        route = routes.route(POSITIONS["C"], "A")
        assert route is not None
        assert (route.length_m > straight + 0.1) is is_in_the_way


def test_flight_times_are_those_of_the_map() -> None:
    """At rest at both ends: d/v + v/a + a/j; a way along cells is a little longer."""
    asked = mission("F at(A)")
    here: Departure | None = None
    seconds = flight_times(asked, FlownRoutes(route_map(asked)), lambda: here)
    change_s = 2.0 / 2.0 + 2.0 / QUAD.jerk_mps3
    assert seconds("H", "A") == pytest.approx(6.0 / 2.0 + change_s, abs=0.4)
    assert seconds("here", "A") == math.inf
    here = at_rest((3.0, 0.0, -2.0))
    assert seconds("here", "A") == pytest.approx(3.0 / 2.0 + change_s, abs=0.4)


def test_a_task_with_bounds_counts_the_bends() -> None:
    """From C to A around M, in the middle."""
    asked = mission("F at(A) & G !at(M)", places="HAC")
    middle = Place("M", (3.0, 3.0, -2.0), Disc(1.0))
    asked = replace(asked, places={**asked.places, "M": middle})
    bounded = replace(asked, task={**asked.task, "often": parse_line("revisit(A) <= 60 s")})
    routes = route_map(asked)
    route = routes.route(POSITIONS["C"], "A")
    assert route is not None and route.blends
    seconds = flight_times(bounded, FlownRoutes(routes))
    assert seconds("C", "A") == Trajectory(route, asked.speed_limits).duration_s + ARRIVAL_S
    assert seconds("C", "A") != flight_times(asked, FlownRoutes(routes))("C", "A")
    routes.hide("A")
    assert seconds("C", "A") == math.inf
    routes.find_place("A", (6.0, 3.0, -2.0))
    found = routes.route(POSITIONS["C"], "A")
    assert found is not None
    assert seconds("C", "A") == Trajectory(found, asked.speed_limits).duration_s + ARRIVAL_S


def test_among_shelves_flights_take_longer_than_their_length_says() -> None:
    asked = load_mission(MISSIONS / "night_watch.yaml")
    routes = route_map(asked)
    routes.add_clearance(0.5)
    by_length_s = routes.passage(routes.goal("Gate"), "Dock").duration_s(asked.speed_limits)
    assert flight_times(asked, FlownRoutes(routes))("Gate", "Dock") > 1.4 * by_length_s


def test_a_table_has_the_ways_that_it_has() -> None:
    asked = mission("F at(A)")
    seconds = given_times(asked, {("H", "A"): 4.0, ("here", "A"): 1.5})
    assert (seconds("H", "A"), seconds("here", "A")) == (4.0, 1.5)
    assert seconds("A", "H") == math.inf
    with pytest.raises(MissionError, match="no place a, of which"):
        given_times(asked, {("H", "a"): 4.0})


@pytest.mark.parametrize("number", [5, np.float32(5), np.int64(5), Fraction(5)])
def test_flight_times_may_be_numbers_of_any_kind(number: float) -> None:
    asked = mission("F at(A)")
    assert given_times(asked, {("H", "A"): number})("H", "A") == 5.0
    assert given_times(asked, lambda origin, goal: number)("H", "A") == 5.0
