"""Moves the setpoint away from a wall if the vehicle comes nearer to it than its route.

A setpoint on a clear route does not keep the vehicle off a wall if the vehicle flies beside its
route: because of an error of the estimate, a gust, or a turn that was too fast. So if the vehicle
itself, by its own position, is nearer to a wall than routes keep and nearer than its setpoint, the
setpoint that is sent is moved away from the wall, by GAIN times the difference. This is the spring
of a repulsive potential (Khatib 1986, Real-time obstacle avoidance), whose zero is the distance of
the setpoint.

    nearer = min(kept, d(setpoint)) - d(vehicle),   moved by = GAIN nearer grad d(vehicle)

It only pushes against a deviation. If a vehicle is on its route, its setpoint is not moved, however
near a wall is: in a passage of any width, or at a start beside a wall. A vehicle that is pushed is
pushed no further than to its setpoint. There is no memory, so nothing has to be reset.

A deviation lasts for seconds, but a pillar that the vehicle passes is near only for half a second.
So vehicle and setpoint are also examined at future times, moved along by the setpoint's velocity.
For what is still ahead, the setpoint is only moved laterally.

Distances are those of the map's distance field, between the centres of its cells.
"""

from __future__ import annotations

import math

from companion.geometry import Ned, NorthEast
from companion.motion.grid import OccupancyGrid
from companion.motion.trajectory import Sample

GAIN = 3.0
"""With this gain a vehicle that drifts comes a quarter as far."""
AHEAD_S = (0.0, 0.4, 0.8, 1.2)
"""Times ahead that are examined: at 2 m/s up to 2.4 m. It takes a second to move aside."""
MOST_M = 0.6
"""The most by which a setpoint is moved."""
REACH_SHARE = 0.95
"""A setpoint is not moved further from the vehicle than this share of the gate's limit."""
STILL: NorthEast = (0.0, 0.0)


def push(
    walls: OccupancyGrid,
    kept_m: float,
    position: Ned,
    told: Sample,
    carrot_m: float,
) -> NorthEast:
    """How to move a setpoint, north and east; STILL if the vehicle is no nearer to a wall than it.

    Args:
        walls: the map at the altitude of the setpoint.
        kept_m: what routes keep from walls, where there is room.
        position: position of the vehicle.
        told: the setpoint.
        carrot_m: the gate's limit for the distance between setpoint and vehicle.
    """
    v_north, v_east, _ = told.velocity
    worst_m, by = 0.0, STILL
    for ahead_s in AHEAD_S if v_north or v_east else AHEAD_S[:1]:
        by_north, by_east = ahead_s * v_north, ahead_s * v_east
        here = (position[0] + by_north, position[1] + by_east)
        there = (told.position[0] + by_north, told.position[1] + by_east)
        cell = walls.cell(here)
        if not walls.contains(*cell) or walls.distance_m[cell] >= kept_m:
            continue
        away, there_away = _distance(walls, here), _distance(walls, there)
        if away is None or there_away is None:
            continue
        nearer_m = min(kept_m, there_away[0]) - away[0]
        if nearer_m > worst_m:
            worst_m, slope = nearer_m, away[1:]
            by = _across(slope, told.velocity) if ahead_s else slope
    size_m = GAIN * worst_m * math.hypot(*by)
    if size_m == 0.0:
        return STILL
    room_m = min(MOST_M, max(0.0, REACH_SHARE * carrot_m - math.dist(position, told.position)))
    share = GAIN * worst_m * min(1.0, room_m / size_m)
    return (share * by[0], share * by[1])


def _across(slope: NorthEast, velocity: Ned) -> NorthEast:
    """The part of a gradient that is perpendicular to a velocity."""
    (north, east), (v_north, v_east, _) = slope, velocity
    speed2 = v_north * v_north + v_east * v_east
    along = (north * v_north + east * v_east) / speed2 if speed2 else 0.0
    return (north - along * v_north, east - along * v_east)


def _distance(walls: OccupancyGrid, point: NorthEast) -> tuple[float, float, float] | None:
    """Distance to the nearest wall and its gradient, north and east; None at the map's edge.

    Both are interpolated bilinearly between the centres of four cells.
    """
    row_m, col_m = (point[i] - walls.origin[i] for i in (0, 1))
    row, col = row_m / walls.cell_m - 0.5, col_m / walls.cell_m - 0.5
    south, west = math.floor(row), math.floor(col)
    if not (walls.contains(south, west) and walls.contains(south + 1, west + 1)):
        return None
    up, right = row - south, col - west
    (sw, se), (nw, ne) = walls.distance_m[south : south + 2, west : west + 2].tolist()
    left_m, right_m = sw + up * (nw - sw), se + up * (ne - se)
    to_north = ((1 - right) * (nw - sw) + right * (ne - se)) / walls.cell_m
    return left_m + right * (right_m - left_m), to_north, (right_m - left_m) / walls.cell_m
