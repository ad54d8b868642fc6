"""What the setpoint of a vehicle that comes nearer to a wall than its route is moved by.

A setpoint on a clear route keeps nobody off a wall who flies beside it: an estimate that is off, a
gust, a turn that was too fast. So where the vehicle itself, by its own position, is nearer to a
wall than routes keep and nearer than its setpoint is, the setpoint that is sent is moved away from
that wall, by GAIN times what the vehicle is nearer: the spring of a repulsive potential (Khatib
1986, Real-time obstacle avoidance), whose zero is the distance that the setpoint has.

    nearer = min(kept, d(setpoint)) - d(vehicle),   moved by = GAIN nearer grad d(vehicle)

It is no more than a push against a deviation: a vehicle on its route, however near to a wall, in a
passage of any width, or at a start beside a wall, is moved by nothing, and one that is pushed is
pushed no further than to where its setpoint is. It has no memory, so nothing has to be reset.

What a vehicle is off by lasts for seconds, and a pillar that it passes is near for half a second.
So both are looked at as they will be, too, moved along by the setpoint's velocity; for what is
still ahead the setpoint is moved across its way alone.

Distances are those of the map's distance field, between the centres of its cells.
"""

from __future__ import annotations

import math

from companion.geometry import Ned, NorthEast
from companion.motion.grid import OccupancyGrid
from companion.motion.trajectory import Sample

GAIN = 3.0
"""A vehicle that drifts comes a quarter as far."""
AHEAD_S = (0.0, 0.4, 0.8, 1.2)
"""When it is looked at: at 2 m/s a pillar is 2.4 m ahead then. It takes a second to move aside."""
MOST_M = 0.6
"""A setpoint is moved by no more."""
REACH_SHARE = 0.95
"""Of the gate's carrot: no further from the vehicle is a setpoint moved."""
STILL: NorthEast = (0.0, 0.0)


def push(
    walls: OccupancyGrid,
    kept_m: float,
    position: Ned,
    told: Sample,
    carrot_m: float,
) -> NorthEast:
    """What to move a setpoint by, north and east; STILL where the vehicle is as far off as it is.

    Args:
        walls: the map at the altitude of the setpoint.
        kept_m: what routes keep from walls, where there is room.
        position: of the vehicle.
        told: the setpoint.
        carrot_m: no setpoint may be further from the vehicle.
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
    """The part of a slope that is across a velocity."""
    (north, east), (v_north, v_east, _) = slope, velocity
    speed2 = v_north * v_north + v_east * v_east
    along = (north * v_north + east * v_east) / speed2 if speed2 else 0.0
    return (north - along * v_north, east - along * v_east)


def _distance(walls: OccupancyGrid, point: NorthEast) -> tuple[float, float, float] | None:
    """Distance to the nearest wall and its slope, north and east; None at the map's rim and off it.

    Both are bilinear between the centres of four cells.
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
