"""Rounding: turns the corners of a route into blends (`blends.py`) that keep clear.

A blend cuts its corner on the inside, where the obstacle stands around which the route leads. So a
corner may be moved outwards, by as much as its blend is away from it, and two corners close
together may become one, where the legs before and after them meet. The largest clear blend is
taken; one almost as large is preferred if its corner is not moved. Sizes are tried from half of the
shorter leg downwards, each first in place, then moved out. If no blend is clear, the corner stays
as it is, and the vehicle stops there.

The test is exact: the curve lies between its chords and the tangents at their ends, and both have
to be clear. An obstacle that touches neither would have to fit between them, which is far less than
a cell.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
import numpy.typing as npt

from companion.motion.blends import Blend, Vector, cross

Waypoints = npt.NDArray[np.float64]
"""(n, 3) NED metres."""
AreClear = Callable[[Waypoints, Waypoints], npt.NDArray[np.bool_]]
"""(n,) whether the legs between two points each (n, 3) are clear."""

MAX_TURN_RAD = np.deg2rad(170.0)  # a sharper corner is not rounded
_LEG_SHARE = 0.45  # greatest reach of the blend at either end, as a share of a leg
_SIZES = 0.7 ** np.arange(12)  # as shares of the greatest reach
_MERGED_M = 0.5  # corners of the same sense that are nearer to each other become one
_MOVES = (0.0, 0.5, 1.0)  # shares of the depth of a blend
_MIN_LEG_M = 1e-3  # waypoints nearer to the one before are left out
_STRAIGHT = 1e-6  # radians; legs that turn by less become one


def corners(waypoints: Waypoints) -> Waypoints:
    """The waypoints at which a route begins, turns or ends; only the end if it has no length."""
    kept = [waypoints[0]]
    for waypoint in waypoints[1:-1]:
        if np.linalg.norm(waypoint - kept[-1]) >= _MIN_LEG_M:
            kept.append(waypoint)
    while kept and np.linalg.norm(waypoints[-1] - kept[-1]) < _MIN_LEG_M:
        kept.pop()
    points = np.array([*kept, waypoints[-1]])
    is_turn = np.linalg.norm(np.diff(_directions(points), axis=0), axis=1) > _STRAIGHT
    inner = np.flatnonzero(is_turn) + 1
    return np.asarray(points[np.unique([0, *inner.tolist(), len(points) - 1])])


def rounded(
    waypoints: Waypoints, are_clear: AreClear, first_moved: int = 1
) -> tuple[Waypoints, tuple[Blend | None, ...]]:
    """The path with its corners rounded, where that is clear.

    Args:
        waypoints: its corners.
        are_clear: tells which legs are clear.
        first_moved: the first corner that may be moved.

    Returns:
        (n, 3) the corners, some of them moved, and the blend at each except the first and the last.
    """
    points = _merged(corners(waypoints), are_clear, first_moved)
    if len(points) < 3:
        return waypoints[[0, -1]], ()
    blends: list[Blend | None] = []
    for index in range(1, len(points) - 1):
        moves = _MOVES if index >= first_moved else _MOVES[:1]
        before = blends[-1] if blends else None
        for candidate in _candidates(points, index, moves):
            previous = _aimed(before, candidate.corner)
            if _is_flyable(candidate, previous, points, index, are_clear):
                points[index] = candidate.corner
                blends[-1:] = [previous] if blends else []
                blends.append(candidate)
                break
        else:
            blends.append(None)
    return points, tuple(blends)


def _merged(points: Waypoints, are_clear: AreClear, first_moved: int) -> Waypoints:
    """The corners, with neighbours merged into one where that is clear."""
    index = first_moved
    while index < len(points) - 2:
        meeting = _meeting(*points[index - 1 : index + 3])
        if meeting is not None:
            starts, ends = (
                np.array([points[index - 1], meeting]),
                np.array([meeting, points[index + 2]]),
            )
            if are_clear(starts, ends).all():
                points = np.vstack([points[:index], [meeting], points[index + 2 :]])
                continue
        index += 1
    return points


def _meeting(before: Vector, first: Vector, second: Vector, after: Vector) -> Vector | None:
    """Where the legs around a short leg meet ahead, seen from above; None if they do not."""
    if np.linalg.norm(second - first) > _MERGED_M:
        return None
    a, b, c = (first - before)[:2], (second - first)[:2], (after - second)[:2]
    turns = cross(np.array([a, b, a]), np.array([b, c, c]))
    if not (np.all(turns > 0) or np.all(turns < 0)):
        return None
    ahead = float(turns[1] / turns[2])  # along the leg before, in lengths of it
    return np.array([*(first[:2] + ahead * a), (first[2] + second[2]) / 2])


def _candidates(points: Waypoints, index: int, moves: tuple[float, ...]) -> Iterator[Blend]:
    """The blends to try at a corner, the best first."""
    before, corner, after = points[index - 1 : index + 2]
    first, second = corner - before, after - corner
    shorter_m = min(float(np.linalg.norm(first)), float(np.linalg.norm(second)))
    directions = _directions(points[index - 1 : index + 2])
    inwards = np.array([*(directions[1] - directions[0])[:2], 0.0])
    width = float(np.linalg.norm(inwards))
    inwards = inwards / width if width > 0 else inwards
    for size in _SIZES.tolist():
        reach_m = _LEG_SHARE * shorter_m * size
        in_place = Blend(corner, directions[0], directions[1], reach_m)
        if in_place.turn_rad > MAX_TURN_RAD:
            return
        for move in moves:
            moved = corner - move * in_place.depth_m * inwards
            yield _between(before, moved, after, reach_m)


def _between(before: Vector, corner: Vector, after: Vector, reach_m: float) -> Blend:
    first, second = _directions(np.array([before, corner, after]))
    return Blend(corner, first, second, reach_m)


def _aimed(blend: Blend | None, target: Vector) -> Blend | None:
    """The blend with another end of its second leg."""
    if blend is None:
        return None
    leg = target - blend.corner
    return Blend(blend.corner, blend.before, leg / np.linalg.norm(leg), blend.reach_m)


def _is_flyable(
    blend: Blend, previous: Blend | None, points: Waypoints, index: int, are_clear: AreClear
) -> bool:
    """Whether a blend, its legs, and the blend before it are clear."""
    before, after = points[index - 1], points[index + 1]
    if blend.turn_rad > MAX_TURN_RAD or blend.turn_rad < _STRAIGHT:
        return False
    curves = [blend.chords(), blend.tangents()]
    if previous is not None:
        is_turn = _STRAIGHT < previous.turn_rad < MAX_TURN_RAD
        leg_m = float(np.linalg.norm(blend.corner - before))
        if not is_turn or previous.reach_m + blend.reach_m > 2 * _LEG_SHARE * leg_m:
            return False
        curves += [previous.chords(), previous.tangents()]
    legs = [np.array([before, blend.corner, after])]
    return all(_is_clear(paths, are_clear) for paths in (curves, legs))  # the short ones first


def _is_clear(paths: list[Waypoints], are_clear: AreClear) -> bool:
    starts = np.vstack([path[:-1] for path in paths])
    ends = np.vstack([path[1:] for path in paths])
    return bool(are_clear(starts, ends).all())


def _directions(points: Waypoints) -> Waypoints:
    legs = np.diff(points, axis=0)
    return np.asarray(legs / np.linalg.norm(legs, axis=1)[:, None])
