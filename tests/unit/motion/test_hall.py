"""The hall has the properties that the surveillance mission relies on.

The vehicle flies A, B, C in turn; halfway from A to B a target appears; the cheapest upload site
is then r1, and once r1 has failed, r2; then it flies home. Costs are lengths of paths.
"""

from __future__ import annotations

import math
from itertools import pairwise, permutations
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest

from companion.geometry import NorthEast, ned_from_enu
from companion.maps import read_map
from companion.motion.region import Disc
from companion.motion.routes import PlaceRegion, RouteMap

HALL = Path(__file__).resolve().parents[3] / "missions" / "maps" / "hall.yaml"
PLACES = {  # east, north; metres
    "Home": (0.0, 0.0),
    "A": (3.0, 11.0),
    "B": (17.5, 10.5),
    "C": (17.0, 1.5),
    "r1": (9.4, 5.4),
    "r2": (9.6, 0.2),
    "r3": (14.4, 2.2),
}
FLOWN = [("Home", "A"), ("A", "B"), ("B", "C"), ("C", "A"), ("r1", "r2"), ("r2", "Home")]
RADIUS_M = 0.6
MARGIN_M = 1.5
FENCE: list[NorthEast] = [(-1.8, -1.8), (-1.8, 21.8), (13.8, 21.8), (13.8, -1.8)]
REGIONS = {
    name: PlaceRegion(ned_from_enu(*place, 1.5), Disc(RADIUS_M), True)
    for name, place in PLACES.items()
}


@pytest.fixture(scope="module")
def routes() -> RouteMap:
    return RouteMap(read_map(HALL), REGIONS, FENCE, clearance_m=0.6)


def plane(name: str) -> NorthEast:
    north, east, _ = REGIONS[name].position
    return north, east


def length(routes: RouteMap, *names: str) -> float:
    """Length of the path through places in turn."""
    return sum(routes.distance_m(plane(a), b) for a, b in pairwise(names))


def legs(routes: RouteMap, start: tuple[float, float, float], to: str) -> npt.NDArray[np.float64]:
    route = routes.route(start, to)
    assert route is not None
    return route.waypoints


def midpoint(waypoints: npt.NDArray[np.float64]) -> tuple[float, float, float]:
    along = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(waypoints, axis=0), axis=1)))
    north, east, down = (float(np.interp(along[-1] / 2, along, x)) for x in waypoints.T)
    return north, east, down


def least_distance(waypoints: npt.NDArray[np.float64], point: NorthEast) -> float:
    fine = [np.linspace(a, b, 500) for a, b in pairwise(waypoints[:, :2])]
    return float(np.linalg.norm(np.vstack(fine) - point, axis=1).min())


@pytest.fixture(scope="module")
def target(routes: RouteMap) -> tuple[float, float, float]:
    """Where the target appears: halfway from A to B."""
    return midpoint(legs(routes, REGIONS["A"].position, "B"))


def test_the_home_position_is_two_metres_from_the_corner() -> None:
    grid = read_map(HALL)
    assert grid.origin == (-2.0, -2.0)
    assert grid.occupied.shape == (160, 240)


def test_every_place_is_free_and_reachable_from_every_other(routes: RouteMap) -> None:
    for a, b in permutations(PLACES, 2):
        assert routes.is_free(plane(a))
        assert length(routes, a, b) < math.inf


def test_the_nearest_place_to_search_from_home_is_a(routes: RouteMap) -> None:
    assert length(routes, "Home", "A") + MARGIN_M < min(length(routes, "Home", x) for x in "BC")


def test_the_cheapest_upload_site_from_the_target_is_r1(
    routes: RouteMap, target: tuple[float, float, float]
) -> None:
    cost = {
        r: routes.distance_m(target[:2], r) + length(routes, r, "Home") for r in ("r1", "r2", "r3")
    }
    assert cost["r1"] + MARGIN_M < min(cost["r2"], cost["r3"])


def test_the_cheapest_upload_site_from_r1_is_r2(routes: RouteMap) -> None:
    assert length(routes, "r1", "r2", "Home") + MARGIN_M < length(routes, "r1", "r3", "Home")


def test_no_route_of_the_mission_comes_near_a_place_that_it_passes(
    routes: RouteMap, target: tuple[float, float, float]
) -> None:
    flown = {(a, b): legs(routes, REGIONS[a].position, b) for a, b in FLOWN}
    flown["target", "r1"] = legs(routes, target, "r1")
    for ends, waypoints in flown.items():
        for name in PLACES.keys() - set(ends):
            assert least_distance(waypoints, plane(name)) > RADIUS_M + 0.3  # tracking error


def test_only_the_leg_from_a_to_b_comes_near_the_target(
    routes: RouteMap, target: tuple[float, float, float]
) -> None:
    for a, b in FLOWN:
        distance_m = least_distance(legs(routes, REGIONS[a].position, b), target[:2])
        assert distance_m < 0.01 if (a, b) == ("A", "B") else distance_m > 1.5
