"""The gate's own geometry, against constructions that know the answer, and matplotlib's."""

from __future__ import annotations

import math
from random import Random

import numpy as np
import pytest
from matplotlib.path import Path

from companion.vehicle.gate_polygons import Corner, distance_to, edges, is_crossing, is_inside_of

RECTANGLE: tuple[Corner, ...] = ((-1.0, -3.0), (-1.0, 5.0), (2.0, 5.0), (2.0, -3.0))
"""North from -1 to 2, east from -3 to 5."""


def star(random: Random) -> tuple[Corner, ...]:
    """A polygon about an odd place, without an edge that crosses another one."""
    count = random.randint(3, 9)
    angles = sorted(random.uniform(0, math.tau) for _ in range(count))
    north, east = random.uniform(-20, 20), random.uniform(-20, 20)
    reaches = [random.uniform(1.0, 9.0) for _ in angles]
    return tuple(
        (north + reach * math.cos(angle), east + reach * math.sin(angle))
        for angle, reach in zip(angles, reaches, strict=True)
    )


def sampled_distance(point: Corner, polygon: tuple[Corner, ...]) -> float:
    """To the nearest of many points of the edges; too long by half a step at most."""
    share = np.linspace(0.0, 1.0, 4001)[:, None]
    ends = [*polygon[1:], polygon[0]]
    return min(
        float(np.hypot(*(np.array(a) + share * np.subtract(b, a) - point).T).min())
        for a, b in zip(polygon, ends, strict=True)
    )


@pytest.mark.parametrize(
    "seed", [*range(10), *(pytest.param(seed, marks=pytest.mark.long) for seed in range(10, 30))]
)
def test_distance_and_side_are_those_of_another_library(seed: int) -> None:
    random = Random(seed)
    polygon = star(random)
    path = Path([*polygon, polygon[0]], closed=True)
    for _ in range(20):
        near = random.choice(polygon)
        point = (near[0] + random.gauss(0, 4), near[1] + random.gauss(0, 4))
        away_m, is_inside = sampled_distance(point, polygon), bool(path.contains_point(point))
        assert distance_to(point, polygon) == pytest.approx(
            -away_m if is_inside else away_m, abs=0.01
        )
        assert is_inside_of(point, polygon, 0.0) is is_inside
        assert is_inside_of(point, polygon, max(0.0, away_m - 0.02)) is is_inside
        assert not is_inside_of(point, polygon, away_m + 0.02)


@pytest.mark.parametrize(
    ("point", "away_m"),
    [
        ((0.0, 0.0), -1.0),
        ((1.0, 4.5), -0.5),
        ((-4.0, 1.0), 3.0),
        ((0.5, 7.0), 2.0),
        ((5.0, 9.0), 5.0),
        ((-4.0, -7.0), 5.0),
        ((2.0, 5.0), 0.0),
        ((-1.0, 2.0), 0.0),
    ],
)
def test_distances_from_a_rectangle(point: Corner, away_m: float) -> None:
    for turned in (RECTANGLE, RECTANGLE[::-1], RECTANGLE[2:] + RECTANGLE[:2]):
        assert distance_to(point, turned) == pytest.approx(away_m, abs=1e-12)


def test_a_margin_is_kept_to_the_point() -> None:
    assert is_inside_of((0.0, 0.0), RECTANGLE, 1.0)
    assert is_inside_of((0.0, 0.0), RECTANGLE, 1.0 + 1e-9) is False
    assert is_inside_of((1.5, 0.0), RECTANGLE, 0.5)


def test_of_two_polygons_side_by_side_a_point_between_them_is_in_one() -> None:
    assert is_inside_of((0.0, -3.0), RECTANGLE, 0.0)
    assert not is_inside_of((0.0, 5.0), RECTANGLE, 0.0)


def test_a_corner_that_stands_twice_is_no_edge_to_divide_by() -> None:
    doubled = (*RECTANGLE[:2], *RECTANGLE[1:])
    assert len(edges(doubled)) == 5
    assert distance_to((4.0, 1.0), doubled) == pytest.approx(2.0)
    assert distance_to((0.0, 0.0), doubled) == pytest.approx(-1.0)


@pytest.mark.parametrize(
    ("b", "d", "crosses"),
    [
        ((4.0, 0.0), (2.0, 3.0), True),
        ((1.0, 0.0), (2.0, 3.0), False),
        ((4.0, 0.0), (2.0, -1.0), False),
        ((4.0, 0.0), (6.0, -3.0), False),
        ((0.0, 4.0), (2.0, 3.0), False),
    ],
)
def test_ways_that_cross(b: Corner, d: Corner, crosses: bool) -> None:
    """From the origin to b, and from 2 m north, 3 m west, to d."""
    a, c = (0.0, 0.0), (2.0, -3.0)
    for one in ((a, b), (b, a)):
        for other in ((c, d), (d, c)):
            assert is_crossing(*one, *other) is crosses
            assert is_crossing(*other, *one) is crosses


def test_ways_that_touch_do_not_cross() -> None:
    assert not is_crossing((0.0, 0.0), (2.0, 0.0), (2.0, -3.0), (2.0, 3.0))
    assert not is_crossing((2.0, -3.0), (2.0, 3.0), (0.0, 0.0), (2.0, 0.0))


@pytest.mark.parametrize("seed", range(10))
def test_ways_cross_where_their_lines_meet_between_their_ends(seed: int) -> None:
    random = Random(seed)
    for _ in range(50):
        a, b, c, d = (np.array([random.uniform(-5, 5), random.uniform(-5, 5)]) for _ in range(4))
        s, t = np.linalg.solve(np.array([b - a, c - d]).T, c - a)
        if min(abs(s), abs(1 - s), abs(t), abs(1 - t)) < 1e-6:
            continue
        between = 0 < s < 1 and 0 < t < 1
        corners = [(float(p[0]), float(p[1])) for p in (a, b, c, d)]
        assert is_crossing(*corners) is bool(between)
