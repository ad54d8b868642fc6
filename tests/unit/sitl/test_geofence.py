"""Fences against an independent point-in-polygon test, PX4's limits, and fences from the wire."""

import math
from itertools import pairwise

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from plans import ACCEPTED, NO_SPACE, download, place, upload
from wire import NAN, Wire, gcs_heartbeat

from companion.geofence import FenceArea, FenceCircle, FencePolygon
from sitl.autopilot.geofence import Geofence
from sitl.autopilot.parameters import Parameters

HOME = (0.0, 0.0, 0.0)
COORDINATE = st.floats(-100, 100)
POINT = st.tuples(COORDINATE, COORDINATE)


def turns(point: tuple[float, float], corners: list[tuple[float, float]]) -> float:
    """How often a polygon winds round a point, by adding up the angles that are seen."""
    total = 0.0
    for a, b in pairwise([*corners, corners[0]]):
        (n1, e1), (n2, e2) = ((c[0] - point[0], c[1] - point[1]) for c in (a, b))
        total += math.atan2(n1 * e2 - e1 * n2, n1 * n2 + e1 * e2)
    return abs(total) / (2 * math.pi)


def star(radii: list[float]) -> list[tuple[float, float]]:
    """A simple polygon round home with these distances of its corners."""
    step = 2 * math.pi / len(radii)
    return [(r * math.cos(i * step), r * math.sin(i * step)) for i, r in enumerate(radii)]


def is_near_edge(point: tuple[float, float], corners: list[tuple[float, float]]) -> bool:
    for (n1, e1), (n2, e2) in pairwise([*corners, corners[0]]):
        length = math.hypot(n2 - n1, e2 - e1)
        along = ((point[0] - n1) * (n2 - n1) + (point[1] - e1) * (e2 - e1)) / length**2
        along = max(0.0, min(1.0, along))
        foot = (n1 + along * (n2 - n1), e1 + along * (e2 - e1))
        if math.dist(foot, point) < 1e-6:
            return True
    return False


@given(radii=st.lists(st.floats(5, 100), min_size=3, max_size=12), point=POINT)
def test_a_polygon_holds_what_it_winds_round(
    radii: list[float], point: tuple[float, float]
) -> None:
    corners = star(radii)
    assume(not is_near_edge(point, corners))
    fence = Geofence()
    fence.load([FenceArea(FencePolygon(tuple(corners)), is_inclusion=True)], {})
    is_inside = round(turns(point, corners)) == 1
    assert fence.is_breached((*point, -5.0), HOME, Parameters()) is not is_inside


@given(centre=POINT, radius_m=st.floats(0.1, 100), point=POINT)
def test_a_circle_holds_what_is_nearer_than_its_radius(
    centre: tuple[float, float], radius_m: float, point: tuple[float, float]
) -> None:
    fence = Geofence()
    for is_inclusion in (True, False):
        fence.load([FenceArea(FenceCircle(centre, radius_m), is_inclusion)], {})
        is_inside = math.dist(centre, point) < radius_m
        assert fence.is_breached((*point, 0.0), HOME, Parameters()) is (is_inside != is_inclusion)


def test_every_area_has_to_be_kept_to() -> None:
    fence = Geofence()
    big, small = FenceCircle((0.0, 0.0), 50.0), FenceCircle((40.0, 0.0), 50.0)
    island = FenceCircle((20.0, 0.0), 5.0)
    fence.load([FenceArea(big, True), FenceArea(small, True), FenceArea(island, False)], {})
    breached = [fence.is_breached((n, 0.0, -5.0), HOME, Parameters()) for n in range(-60, 100, 5)]
    kept = [n for n, is_out in zip(range(-60, 100, 5), breached, strict=True) if not is_out]
    assert kept == [-5, 0, 5, 10, 15, 25, 30, 35, 40, 45]


@pytest.mark.parametrize(
    ("position", "is_breached"),
    [
        ((29.9, 0.0, -19.9), False),
        ((30.1, 0.0, -5.0), True),
        ((0.0, -30.1, -5.0), True),
        ((0.0, 0.0, -20.1), True),
        ((0.0, 0.0, 500.0), False),
    ],
)
def test_distances_from_home(position: tuple[float, float, float], is_breached: bool) -> None:
    home = (0.0, 0.0, 0.0)
    limits = Parameters({"GF_MAX_HOR_DIST": 30.0, "GF_MAX_VER_DIST": 20.0})
    assert Geofence().is_breached(position, home, limits) is is_breached
    assert Geofence().is_breached(position, home, Parameters()) is False


SQUARE = [(-20, -20, 0), (-20, 20, 0), (20, 20, 0), (20, -20, 0)]


def test_a_fence_from_the_wire() -> None:
    wire = Wire()
    corners = [place(5001, point, 4.0, kind=1) for point in SQUARE]
    island = place(5004, (10.0, 0.0, 0.0), 3.0, kind=1)
    assert upload(wire, [*corners, island, place(5000, (0, 0, 5), kind=1)], kind=1) == ACCEPTED
    assert [item.command for item in download(wire, 1)] == [5001] * 4 + [5004, 5000]
    autopilot = wire.simulation._autopilot
    for north_m, is_breached in [(0.0, False), (19.99, False), (20.01, True), (10.0, True)]:
        position = (north_m, 0.0, -5.0)
        assert autopilot.fence.is_breached(position, HOME, autopilot.parameters) is is_breached


def test_a_polygon_that_is_not_complete_is_taken_and_left_out() -> None:
    """As in PX4: the protocol looks at each item alone."""
    wire = Wire()
    wire.send(gcs_heartbeat())
    short = [place(5001, point, 5.0, kind=1) for point in SQUARE]
    assert upload(wire, short, kind=1) == ACCEPTED
    wire.run(0.1)
    assert [item.command for item in download(wire, 1)] == [5001] * 4
    assert wire.simulation._autopilot.fence.areas == ()
    assert "Geofence invalid, doesn't contain Home position" in wire.texts()


def test_behind_a_circle_each_corner_begins_a_polygon() -> None:
    """The trap of PX4's geofence.cpp: four corners are four polygons that read on."""
    wire = Wire()
    island = place(5004, (500.0, 0.0, 0.0), 3.0, kind=1)
    corners = [place(5001, point, 4.0, kind=1) for point in SQUARE]
    others = [place(5001, point, 4.0, kind=1) for point in SQUARE]
    assert upload(wire, [island, *corners, *others], kind=1) == ACCEPTED
    wire.run(0.1)
    areas = wire.simulation._autopilot.fence.areas
    polygons = [area.shape for area in areas if isinstance(area.shape, FencePolygon)]
    assert len(areas) - len(polygons) == 1
    assert len(polygons) == 5  # of eight; three go beyond the last item, and contain nothing
    assert upload(wire, [*corners, island], kind=1) == ACCEPTED
    wire.run(0.1)
    assert len(wire.simulation._autopilot.fence.areas) == 2


def test_more_than_64_points_have_no_room() -> None:
    wire = Wire()
    many = [place(5003, (0.0, 0.0, 0.0), 40.0, kind=1)] * 65
    assert upload(wire, many, kind=1) == NO_SPACE


def test_a_fence_around_somewhere_else_is_not_taken_up() -> None:
    wire = Wire()
    wire.send(gcs_heartbeat())
    assert upload(wire, [place(5003, (500.0, 0.0, NAN), 40.0, kind=1)], kind=1) == ACCEPTED
    wire.run(0.1)
    assert wire.simulation._autopilot.fence.areas == ()
    assert "Geofence invalid, doesn't contain Home position" in wire.texts()


def test_in_flight_a_fence_must_hold_the_vehicle_too() -> None:
    wire = Wire()
    wire.send(gcs_heartbeat())
    wire.fly_offboard(30.0, 0.0, -5.0)
    fences = [
        place(5003, (0.0, 0.0, 0.0), 20.0, kind=1),
        place(5003, (0.0, 0.0, 0.0), 60.0, kind=1),
    ]
    assert upload(wire, fences, kind=1) == ACCEPTED
    wire.run(0.02)
    (area,) = wire.simulation._autopilot.fence.areas
    assert isinstance(area.shape, FenceCircle) and area.shape.radius_m == 60.0
    assert "Geofence invalid, doesn't contain current vehicle position" in "".join(wire.texts())
    assert wire.simulation.mode == "OFFBOARD"
