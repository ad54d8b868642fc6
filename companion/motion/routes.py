"""Routes to places on the map, as straight legs, and their lengths.

The cost-to-go of a place gives the shortest path along free cells from everywhere
(`distance_maps.py`). String pulling (`string_pulling.py`) shortens it to legs that cross only free
cells (`free_space.py`).

Routes respect the labels of the task: no leg enters the region of another exclusive place from
outside, but legs may stay within one and leave it. So a vehicle can leave its place, and passes
through no other place unrecorded.

Routes are planned in the plane; the altitude changes linearly along the route. Left out: low
obstacles (`layered_routes.py`), and the vehicle's dynamics (`trajectory.py`).
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from companion.geometry import Ned, NorthEast
from companion.motion.blends import Blend
from companion.motion.clearance_choice import RouteAtClearance, decisive_routes
from companion.motion.clearance_level import ClearanceLevel, Obstacles, Room, levels_from
from companion.motion.free_space import FreeSpace, points_of
from companion.motion.grid import OccupancyGrid, cells_inside
from companion.motion.line_of_sight import Points
from companion.motion.polygons import cells_beside, cells_of
from companion.motion.region import Region
from companion.motion.region_edges import RegionEdges
from companion.motion.regions import Regions
from companion.motion.rounding import Waypoints, rounded
from companion.motion.string_pulling import length, pull_string

CELLS_PER_TICK = 10_000
"""Cells that are searched in one tick, because the same loop sends the setpoints."""


@dataclass(frozen=True, slots=True)
class PlaceRegion:
    """A place and its region, as routes see them.

    Attributes:
        position: the centre of the region, where routes to the place end at first.
        region: where the vehicle is at the place; only its horizontal extent is used here.
        is_exclusive: whether the task mentions the place: routes to elsewhere avoid its region.
    """

    position: Ned
    region: Region
    is_exclusive: bool


@dataclass(frozen=True, slots=True, eq=False)
class Route:
    """Straight legs from where the vehicle is to a place, and how their corners are rounded.

    Attributes:
        waypoints: (n, 3) float, NED metres, n >= 2; the first is the start, the last the place.
        blends: at each corner, None if it is not rounded; () if no corner is.
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
        grid: the map as known at first.
        places: by name.
        fence: north-east corners of the polygon that no route leaves.
        clearance_m: the least distance of a route from an obstacle.
        fence_margin_m: the least distance from the fence.
        keep_out: the corners of areas that routes treat as obstacles.
        within: more polygons that no route leaves.
    """

    def __init__(
        self,
        grid: OccupancyGrid,
        places: Mapping[str, PlaceRegion],
        fence: Sequence[NorthEast],
        clearance_m: float,
        fence_margin_m: float = 0.0,
        keep_out: Iterable[Sequence[NorthEast]] = (),
        within: Iterable[Sequence[NorthEast]] = (),
    ) -> None:
        self.version = 0
        self._grid = grid
        zones = cells_of(grid.with_occupied(np.zeros_like(grid.occupied)), keep_out).occupied
        self._zones = zones if zones.any() else None
        self._goals = {name: place.position for name, place in places.items()}
        exclusive = {name: place for name, place in places.items() if place.is_exclusive}
        regions = _regions(grid, exclusive)
        inside = np.ones_like(grid.occupied)
        for polygon in (fence, *within):
            beside = cells_beside(grid.occupied.shape, points_of(grid, polygon), 0)
            inside &= cells_inside(grid, polygon, fence_margin_m) & ~beside
        self._others = {name: regions.without(name) for name in places}
        edges = RegionEdges(inside.shape, regions)
        self._room = Room(clearance_m, inside, edges, self._others, self._goals)
        self._least = ClearanceLevel(self._room, self._obstacles(grid), clearance_m)
        self._least.look()  # its cells determine the version
        self._levels = [self._least]

    def see(self, grid: OccupancyGrid) -> None:
        """Takes over a map with the same cells, of which others are occupied."""
        obstacles = self._obstacles(grid)
        self.version += any([level.see(obstacles) for level in self._levels])

    def _obstacles(self, grid: OccupancyGrid) -> Obstacles:
        walls, zones = grid.occupied, self._zones
        grid = grid if zones is None else grid.with_occupied(walls | zones)
        return Obstacles(grid, walls, 2 * self._room.least_m)

    @property
    def _usable(self) -> npt.NDArray[np.bool_]:
        """(rows, cols) the cells that are inside all fences and outside all zones."""
        inside = self._room.is_inside
        return inside if self._zones is None else inside & ~self._zones

    @property
    def obstacles(self) -> OccupancyGrid:
        """The map, with zones occupied as well."""
        return self._least.space.grid

    def is_usable(self, position: NorthEast) -> bool:
        """Whether a position is inside all fences and outside all zones."""
        cell = self._grid.cell(position)
        return self._grid.contains(*cell) and bool(self._usable[cell])

    def is_as_wide_as(self, other: RouteMap) -> bool:
        """Whether fences and zones leave the same cells as in another one, on the same map."""
        return np.array_equal(self._usable, other._usable)

    def add_clearance(self, added_m: float) -> None:
        """Makes routes keep more distance from obstacles, where the map has room for it."""
        self._levels = levels_from(self._least, added_m)
        self.version += 1

    def find(self, max_cells: int) -> bool:
        """Searches about `max_cells` cells of outdated distance maps; True once all are current."""
        first, *lower = self._levels
        return first.maps.find(max_cells) and all(level.repair(max_cells) for level in lower)

    def search(self, start: NorthEast, place: str, max_cells: int) -> bool:
        """Searches about `max_cells` cells for the routes to a place; True once they are known.

        After that, `distance_m` and `route` from this start need no search.

        Raises:
            KeyError: there is no such place.
        """
        if self._is_in_sight(start, place) or not self.is_connected(start, place):
            return True
        for route in self._decisive_routes(start, place):
            max_cells -= route.level.search(start, place, max_cells)
            if not route.level.is_known(start, place):
                return False
        return True

    def aim(self, place: str, goal: Ned) -> None:
        """Makes routes to a place end at another point; its region stays where it is."""
        if self._goals[place] != goal:
            self._goals[place] = goal
            for level in self._levels:
                level.aim(place)

    def goal(self, place: str) -> Ned:
        """The point where routes to a place end now."""
        return self._goals[place]

    def is_clear(self, path: npt.NDArray[np.float64]) -> bool:
        """Whether a path (n, 2) or (n, 3) in metres is in the fence and has the least clearance.
        A path that begins in no free cell may lead out of there: its first leg must keep as far
        from obstacles as its start does, less one cell.
        """
        space = self._least.space
        points = space.point(path)
        legs = space.is_clear(points[:-1], points[1:])
        if space.is_clear(points[0], points[0]):
            return bool(legs.all())
        return bool(space.keeps_away(points[0], points[1]) and legs[1:].all())

    def is_free(self, position: NorthEast) -> bool:
        """Whether a position has the least clearance and lies inside the fence."""
        return self._least.space.is_free(self._grid.cell(position))

    def is_connected(self, start: NorthEast, place: str) -> bool:
        """Whether free cells lead from near a start to a place, ignoring the regions in between.

        Quick: if a place is cut off, this is known without a search.
        """
        goal = self._grid.cell(self._goals[place][:2])
        return self._least.space.is_connected(start, goal)

    def distance_m(self, start: NorthEast, place: str) -> float:
        """Horizontal length of the leg to a place, or of the path along cells; inf without any.
        Raises:
            KeyError: there is no such place.
        """
        straight_m = math.dist(start, self._goals[place][:2])
        if self._is_in_sight(start, place):
            return straight_m
        length_m = self._chosen(start, place).length_m
        is_direct = math.isinf(length_m) and self._is_in_sight(start, place, self._least)
        return straight_m if is_direct else length_m

    def route_from_motion(
        self, start: Ned, stop: Ned, place: str, down_m: float | None = None
    ) -> Route | None:
        """A route whose first leg leads straight ahead to where the vehicle can stop.

        None if that leg comes more than a cell closer to obstacles than the start or the least
        clearance allows, or if no path leads on from there. Then only a route from rest is
        possible, from which the vehicle deviates while it brakes.

        Args:
            start: where the vehicle is.
            stop: where it can come to rest.
            place: where to fly.
            down_m: the altitude (down) at which it ends; None for that of the place.
        """
        least = self._least.space
        if not least.keeps_away(least.point(start), least.point(stop)):
            return None
        return self._route(stop, place, down_m, flown=[start])

    def route(self, start: Ned, place: str, down_m: float | None = None) -> Route | None:
        """The shortest route to a place, after string pulling and rounding; None if there is none.

        If the start is not free (the vehicle has drifted, or something has come near it), the first
        leg leads to the nearest free cell within ENTRY_M without coming nearer to obstacles than
        the start. If there is no such cell, it leads to the nearest one across no occupied cell.

        Raises:
            KeyError: there is no such place.
        """
        return self._route(start, place, down_m, flown=[])

    def _route(
        self, start: Ned, place: str, down_m: float | None, flown: list[Ned]
    ) -> Route | None:
        """A route to a place, after points that are flown in any case."""
        goal, others = self._goals[place], self._others[place]
        space, chosen = self._levels[0].space, None
        if not self._is_in_sight(start[:2], place):
            chosen = self._chosen(start[:2], place)
        if chosen is None:
            points = space.point([start[:2], goal[:2]])
        elif entry := chosen.entry:
            space = chosen.level.around(*(point[:2] for point in (*flown, start)))
            cells = entry.to_go.path(entry.cell) + 0.5
            path = np.vstack([space.point(start), cells, space.point(goal)])
            kept = 0 if space.is_clear(path[0], path[0]) else 1  # the leg out of the clearance band
            pulled = pull_string(path[kept:], _ClearLegs(space, others.around(path)))
            points = np.vstack([path[:kept], pulled])
        elif self._is_in_sight(start[:2], place, self._least):
            space = self._least.space
            points = space.point([start[:2], goal[:2]])
        else:
            return None
        plane = points * self._grid.cell_m + self._grid.origin
        plane[0], plane[-1] = start[:2], goal[:2]  # exact, without rounding errors
        last_down_m = goal[2] if down_m is None else down_m
        waypoints = np.vstack([*flown, _with_altitude(plane, start[2], last_down_m)])
        legs = _ClearLegs(space, others)

        def are_clear(a: Waypoints, b: Waypoints) -> npt.NDArray[np.bool_]:
            return legs.are_clear(space.point(a), space.point(b))

        return Route(*rounded(waypoints, are_clear, first_moved=1 + len(flown)))

    def _is_in_sight(
        self, start: NorthEast, place: str, level: ClearanceLevel | None = None
    ) -> bool:
        """Whether a straight leg to a place is clear; without any search.

        Args:
            start: where the leg begins.
            place: where it ends.
            level: the clearance level; None for the highest. At the edge of the region around the
                start there is no other route to a place, so the least level counts there, too.
        """
        space = (level or self._levels[0]).space
        legs = _ClearLegs(space, self._others[place])
        leg = space.point(start), space.point(self._goals[place][:2])
        return bool(legs.may_be_clear(*leg) and legs.are_clear(*leg))

    def _chosen(self, start: NorthEast, place: str) -> RouteAtClearance:
        """The route by which a place is reached, at one clearance, if there is one."""
        *_, chosen = self._decisive_routes(start, place)
        return chosen

    def _decisive_routes(self, start: NorthEast, place: str) -> Iterator[RouteAtClearance]:
        straight_m = math.dist(start, self._goals[place][:2])
        return decisive_routes(self._levels, start, place, straight_m)


def _regions(grid: OccupancyGrid, places: Mapping[str, PlaceRegion]) -> Regions:
    """The regions of some places, in the cells of a map."""
    centres = points_of(grid, np.array([p.position for p in places.values()]).reshape(-1, 3))
    outlines = {name: place.region.outline() for name, place in places.items()}
    polygons = {name: points_of(grid, corners) for name, corners in outlines.items() if corners}
    radii = [
        np.linalg.norm(polygons[name] - centre, axis=1).max()
        if name in polygons
        else place.region.inner_m(place.position) / grid.cell_m
        for (name, place), centre in zip(places.items(), centres, strict=True)
    ]
    return Regions(tuple(places), centres, np.array(radii, dtype=np.float64), polygons)


@dataclass(frozen=True, slots=True)
class _ClearLegs:
    """The legs that cross only free cells and enter no other region; a `LegTest`."""

    space: FreeSpace
    others: Regions

    def may_be_clear(self, a: Points, b: Points) -> npt.NDArray[np.bool_]:
        return self.space.may_be_clear(a, b)

    def are_clear(self, a: Points, b: Points) -> npt.NDArray[np.bool_]:
        return self.space.is_clear(a, b) & ~self.others.are_entered(a, b)


def _with_altitude(
    plane: npt.NDArray[np.float64], first_down_m: float, last_down_m: float
) -> npt.NDArray[np.float64]:
    """(n, 3) waypoints from (n, 2) ones; down changes in proportion to the length in the plane."""
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(plane, axis=0), axis=1))])
    share = along / along[-1] if along[-1] > 0 else np.linspace(0.0, 1.0, len(plane))
    return np.column_stack([plane, first_down_m + share * (last_down_m - first_down_m)])
