"""A corner rounded by two clothoids: closed forms, and that nothing jumps."""

from __future__ import annotations

import math

import numpy as np
import pytest

from companion.motion.blends import Blend, Vector, cross
from companion.motion.profile import SpeedLimits

LIMITS = SpeedLimits(2.0, 2.0, 8.0)
TURNS_DEG = [1, 20, 90, 150, 169]


def blend_of(turn_deg: float, reach_m: float = 1.0) -> Blend:
    turn = math.radians(turn_deg)
    after = np.array([math.cos(turn), math.sin(turn), 0.0])
    return Blend(np.array([3.0, 1.0, -2.0]), np.array([1.0, 0.0, 0.0]), after, reach_m)


@pytest.mark.parametrize("turn_deg", TURNS_DEG)
def test_it_leaves_one_leg_and_joins_the_other_straight(turn_deg: float) -> None:
    blend = blend_of(turn_deg)
    begin, end = blend.position([0.0, blend.length_m])
    assert begin == pytest.approx(blend.corner - blend.before)
    assert end == pytest.approx(blend.corner + blend.after)
    first, last = blend.direction([0.0, blend.length_m])
    assert first == pytest.approx(blend.before, abs=1e-9)
    assert last == pytest.approx(blend.after, abs=1e-9)
    assert blend.at(0.0).curvature == pytest.approx(np.zeros(3))
    assert blend.at(blend.length_m).curvature == pytest.approx(np.zeros(3), abs=1e-9)


@pytest.mark.parametrize("turn_deg", TURNS_DEG)
def test_a_point_that_is_flown_is_one_of_its_points(turn_deg: float) -> None:
    blend = blend_of(turn_deg)
    along = np.linspace(0.0, blend.length_m, 50)
    points = [blend.at(x) for x in along]
    assert [point.position for point in points] == pytest.approx(blend.position(along))
    assert [point.direction for point in points] == pytest.approx(blend.direction(along))


@pytest.mark.parametrize("turn_deg", TURNS_DEG)
def test_direction_and_curvature_are_what_the_points_say(turn_deg: float) -> None:
    blend = blend_of(turn_deg)
    step_m = blend.length_m / 4000
    along = np.arange(4001) * step_m
    points, ways = blend.position(along), blend.direction(along)
    chords = np.diff(points, axis=0) / step_m
    assert np.abs(chords - (ways[:-1] + ways[1:]) / 2).max() < 1e-5
    curvature = np.array([blend.at(x).curvature for x in along[:-1] + step_m / 2])
    assert np.abs(np.diff(ways, axis=0) / step_m - curvature).max() < 1e-2 * blend.turn_rad
    greatest = np.linalg.norm(curvature, axis=1).max()
    assert greatest == pytest.approx(2 * blend.turn_rad / blend.length_m, rel=1e-3)


@pytest.mark.parametrize("turn_deg", TURNS_DEG)
def test_its_depth_is_the_distance_from_the_corner(turn_deg: float) -> None:
    blend = blend_of(turn_deg)
    away = np.linalg.norm(
        blend.position(np.linspace(0, blend.length_m, 999)) - blend.corner, axis=1
    )
    assert away.min() == pytest.approx(blend.depth_m, rel=1e-4)


@pytest.mark.parametrize("turn_deg", TURNS_DEG)
def test_it_lies_between_its_chords_and_their_tangents(turn_deg: float) -> None:
    """It turns to the right: left of the chord over each part of it, right of every tangent."""
    blend = blend_of(turn_deg, reach_m=2.0)
    chords, tangents = blend.chords(), blend.tangents()
    parts = len(chords) - 1
    for part in range(parts):
        for share in (0.1, 0.5, 0.9):
            point = blend.position((part + share) / parts * blend.length_m)
            assert right_of(chords[part : part + 2], point).max() <= 1e-9
            assert right_of(tangents, point).min() >= -1e-9


def right_of(line: Vector, point: Vector) -> Vector:
    """How far a point lies to the right of the lines through consecutive points, in areas."""
    return cross(np.diff(line[:, :2], axis=0), (point - line[:-1])[:, :2])


@pytest.mark.parametrize("turn_deg", TURNS_DEG)
def test_its_speed_keeps_acceleration_and_jerk(turn_deg: float) -> None:
    blend = blend_of(turn_deg, reach_m=0.4)
    speed_mps = blend.speed_mps(LIMITS)
    greatest = 2 * blend.turn_rad / blend.length_m
    used = (
        speed_mps / LIMITS.speed_mps,
        speed_mps**2 * greatest / LIMITS.acceleration_mps2,
        speed_mps**3 * 2 * greatest / blend.length_m / LIMITS.jerk_mps3,
    )
    assert max(used) == pytest.approx(1.0)


def test_a_turn_that_is_steepest_in_its_middle_keeps_the_vertical_limit() -> None:
    limits = SpeedLimits(9.0, 99.0, 999.0, climb_mps=1.0, descent_mps=0.6)
    level = math.sqrt(0.5)
    for sign, most_mps in ((1.0, 0.6), (-1.0, 1.0)):
        before, after = np.array([level, 0, sign * level]), np.array([-level, 0, sign * level])
        blend = Blend(np.zeros(3), before, after, 1.0)
        downs = blend.direction(np.linspace(0, blend.length_m, 99))[:, 2]
        assert np.abs(downs).max() * blend.speed_mps(limits) == pytest.approx(most_mps, rel=1e-3)
