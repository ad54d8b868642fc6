"""Routes to places on the map, as straight legs, and their lengths.

The cost-to-go of a place gives the shortest path along free cells from everywhere
(`distance_maps.py`); string pulling (`string_pulling.py`) shortens it to legs that cross free
cells only (`free_space.py`).

Routes respect the labels of the task: no leg comes from outside into the region of another
exclusive place, but legs within and out of one are allowed. So a vehicle can leave the place
where it is, and passes through no other unrecorded.

Routes are planned in the plane; the altitude changes evenly along the way. Left out: the third
dimension of obstacles, and the vehicle's dynamics (`trajectory.py`).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from companion.geometry import Ned, NorthEast
from companion.motion.blends import Blend
from companion.motion.cost_to_go import CostToGo
from companion.motion.distance_maps import DistanceMaps
from companion.motion.free_space import FreeSpace
from companion.motion.grid import OccupancyGrid, cells_inside
from companion.motion.grid_graph import Cell
from companion.motion.line_of_sight import Points
from companion.motion.regions import Regions
from companion.motion.rounding import Waypoints, rounded
from companion.motion.string_pulling import length, pull_string


@dataclass(frozen=True, slots=True)
class PlaceRegion:
    """A place and the disc around it, as routes see them.

    Attributes:
        position: the centre of the region, where routes to the place end at first.
        radius_m: radius of the region in the north-east plane.
        is_exclusive: the task mentions the place: no route to elsewhere may enter the region.
    """

    position: Ned
    radius_m: float
    is_exclusive: bool


@dataclass(frozen=True, slots=True, eq=False)
class Route:
    """Straight legs from where the vehicle is to a place, and how their corners are rounded.

    Attributes:
        waypoints: (n, 3) float, NED metres, n >= 2; the first is the start, the last the place.
        blends: at each corner, None where it is not rounded; () if none is.
    """

    waypoints: npt.NDArray[np.float64]
    blends: tuple[Blend | None, ...] = ()

    @property
    def length_m(self) -> float:
        """Length of all legs in space."""
        return length(self.waypoints)


class RouteMap:
    """Routes and distances to places on the map as it is known now.

    Attributes:
        version: changes whenever the free cells do.

    Args:
        grid: the map as it is known at first.
        places: by name.
        fence: north-east corners of the polygon that no route leaves.
        clearance_m: least distance from a free cell's centre to an occupied cell's centre.
    """

    def __init__(
        self,
        grid: OccupancyGrid,
        places: Mapping[str, PlaceRegion],
        fence: Sequence[NorthEast],
        clearance_m: float,
    ) -> None:
        self.version = 0
        self._clearance_m = clearance_m
        self._is_inside = cells_inside(grid, fence)
        self._space = space = FreeSpace(grid, self._is_inside, clearance_m)
        exclusive = {name: place for name, place in places.items() if place.is_exclusive}
        regions = Regions(
            tuple(exclusive),
            space.point(np.array([place.position for place in exclusive.values()]).reshape(-1, 3)),
            np.array([place.radius_m for place in exclusive.values()]) / grid.cell_m,
        )
        self._others = {name: regions.without(name) for name in places}
        self._goals = {name: place.position for name, place in places.items()}
        goals = {name: space.point(goal) for name, goal in self._goals.items()}
        self._distance_maps = DistanceMaps(goals, regions, space.free)

    def see(self, grid: OccupancyGrid) -> None:
        """Takes over a map with the same cells, of which others are occupied."""
        before, self._space = self._space, FreeSpace(grid, self._is_inside, self._clearance_m)
        if not np.array_equal(before.free, self._space.free):
            self._distance_maps.see(self._space.free)
            self.version += 1

    def find(self, max_cells: int) -> bool:
        """Searches about `max_cells` cells of outdated distance maps; True once all are current."""
        return self._distance_maps.find(max_cells)

    def aim(self, place: str, goal: Ned) -> None:
        """Lets routes to a place end at another point; its region stays where it is."""
        if self._goals[place] != goal:
            self._goals[place] = goal
            self._distance_maps.aim(place, self._space.point(goal))

    def goal(self, place: str) -> Ned:
        """The point where routes to a place end now."""
        return self._goals[place]

    def is_clear(self, path: npt.NDArray[np.float64]) -> bool:
        """Whether a path crosses free cells only; (n, 2) or (n, 3) metres.

        A path that begins in no free cell may lead out of there: its first leg must stay as far
        from obstacles as its start, less a cell.
        """
        points = self._space.point(path)
        legs = self._space.is_clear(points[:-1], points[1:])
        if self._space.is_clear(points[0], points[0]):
            return bool(legs.all())
        return bool(self._space.keeps_away(points[0], points[1]) and legs[1:].all())

    def is_free(self, position: NorthEast) -> bool:
        """Whether a position has the clearance and lies inside the fence."""
        return self._space.is_free(self._space.grid.cell(position))

    def is_connected(self, start: NorthEast, place: str) -> bool:
        """Whether free cells lead from near a start to a place, whatever regions lie between.

        Quick: a place that is cut off is known without a search.
        """
        goal = self._space.grid.cell(self._goals[place][:2])
        return self._space.is_connected(start, goal)

    def distance_m(self, start: NorthEast, place: str) -> float:
        """Length of the path along cells to a place, in the plane; inf if there is none.

        Raises:
            KeyError: there is no such place.
        """
        entry = self._entry(start, place)
        if entry is None:
            return math.inf
        (to_go, cell), grid = entry, self._space.grid
        goal = self._goals[place][:2]
        if to_go.cost[cell] == 0:
            return math.dist(start, goal)
        first = math.dist(start, grid.centre(*cell))
        last = math.dist(goal, grid.centre(*grid.cell(goal)))
        return first + float(to_go.cost[cell]) * grid.cell_m + last

    def route_from_motion(self, start: Ned, stop: Ned, place: str) -> Route | None:
        """A route whose first leg leads to where the vehicle can stop, straight ahead.

        None if that leg comes closer to obstacles than the start or the clearance allows, by more
        than a cell, or if no path leads on from there. What is left then is a route from a start
        at rest, from which the vehicle deviates while it brakes.

        Args:
            start: where the vehicle is.
            stop: where it can come to rest.
            place: where to fly.
        """
        is_clear = self._space.keeps_away(self._space.point(start), self._space.point(stop))
        waypoints = self._waypoints(stop, place) if is_clear else None
        if waypoints is None:
            return None
        return self._rounded(np.vstack([start, waypoints]), place, first_moved=2)

    def route(self, start: Ned, place: str) -> Route | None:
        """The shortest route to a place, after string pulling and rounding; None if there is none.

        A start that is not free (the vehicle has drifted, or something has come near it) is left by
        a leg to the nearest free cell within ENTRY_M that comes no nearer to obstacles than the
        start is; if there is none, to the nearest one across no occupied cell.

        Raises:
            KeyError: there is no such place.
        """
        waypoints = self._waypoints(start, place)
        return self._rounded(waypoints, place) if waypoints is not None else None

    def _waypoints(self, start: Ned, place: str) -> npt.NDArray[np.float64] | None:
        """(n, 3) the legs of a route, before rounding."""
        entry = self._entry((start[0], start[1]), place)
        if entry is None:
            return None
        (to_go, cell), space = entry, self._space
        goal = self._goals[place]
        path = np.vstack([space.point(start), to_go.path(cell) + 0.5, space.point(goal)])
        kept = 0 if space.is_clear(path[0], path[0]) else 1  # the leg out of the clearance band
        legs = _ClearLegs(space, self._others[place].around(path))
        points = np.vstack([path[:kept], pull_string(path[kept:], legs)])
        plane = points * space.grid.cell_m + space.grid.origin
        plane[0], plane[-1] = start[:2], goal[:2]  # exactly, whatever the rounding
        return _with_altitude(plane, start[2], goal[2])

    def _rounded(
        self, waypoints: npt.NDArray[np.float64], place: str, first_moved: int = 1
    ) -> Route:
        space = self._space
        legs = _ClearLegs(space, self._others[place])

        def are_clear(a: Waypoints, b: Waypoints) -> npt.NDArray[np.bool_]:
            return legs.are_clear(space.point(a), space.point(b))

        return Route(*rounded(waypoints, are_clear, first_moved))

    def _entry(self, start: NorthEast, place: str) -> tuple[CostToGo, Cell] | None:
        """The cost-to-go of a place and the cell where a route enters it; None if there is none."""
        to_go = self._distance_maps.cost_to_go(place) if self.is_connected(start, place) else None
        cell = self._space.entry(start, self._others[place], to_go.cost) if to_go else None
        return (to_go, cell) if to_go and cell else None


@dataclass(frozen=True, slots=True)
class _ClearLegs:
    """The legs across free cells that enter no other region; a `LegTest`."""

    space: FreeSpace
    others: Regions

    def may_be_clear(self, a: Points, b: Points) -> npt.NDArray[np.bool_]:
        return self.space.may_be_clear(a, b)

    def are_clear(self, a: Points, b: Points) -> npt.NDArray[np.bool_]:
        return self.space.is_clear(a, b) & ~self.others.are_entered(a, b)


def _with_altitude(
    plane: npt.NDArray[np.float64], first_down_m: float, last_down_m: float
) -> npt.NDArray[np.float64]:
    """(n, 3) waypoints of (n, 2) ones; down changes in proportion to the length in the plane."""
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(plane, axis=0), axis=1))])
    share = along / along[-1] if along[-1] > 0 else np.linspace(0.0, 1.0, len(plane))
    return np.column_stack([plane, first_down_m + share * (last_down_m - first_down_m)])
