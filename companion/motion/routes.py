"""Routes on the map: how far is it to a place, and along which straight legs?

One field per place gives the way along free cells from everywhere (`approaches.py`); the route is
that way pulled tight (`taut.py`) by legs that cross free cells only (`free_space.py`).

Routes respect the labels of the task: no leg comes from outside into the
region of another exclusive place, but legs within and out of one are allowed. So a vehicle can
leave the place where it is, and passes through no other unrecorded.

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
from companion.motion.approaches import Approaches
from companion.motion.fields import Field
from companion.motion.free_space import FreeSpace
from companion.motion.grid import OccupancyGrid, cells_inside
from companion.motion.moves import Cell
from companion.motion.regions import Regions
from companion.motion.sight import Points
from companion.motion.taut import length, pulled_tight


@dataclass(frozen=True, slots=True)
class Site:
    """A place as routes see it.

    Attributes:
        position: the middle of its region, where routes to it end at first.
        radius_m: radius of its region in the north-east plane.
        is_exclusive: the task mentions it: no route to elsewhere may enter its region.
    """

    position: Ned
    radius_m: float
    is_exclusive: bool


@dataclass(frozen=True, slots=True, eq=False)
class Route:
    """Straight legs from where the vehicle is to a place.

    Attributes:
        waypoints: (n, 3) float, NED metres, n >= 2; the first is the start, the last the place.
    """

    waypoints: npt.NDArray[np.float64]

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
        sites: the places, by name.
        fence: north-east corners of the polygon that no route leaves.
        clearance_m: least distance from a free cell's centre to an occupied cell's centre.
    """

    def __init__(
        self,
        grid: OccupancyGrid,
        sites: Mapping[str, Site],
        fence: Sequence[NorthEast],
        clearance_m: float,
    ) -> None:
        self.version = 0
        self._clearance_m = clearance_m
        self._is_inside = cells_inside(grid, fence)
        self._space = space = FreeSpace(grid, self._is_inside, clearance_m)
        exclusive = {name: site for name, site in sites.items() if site.is_exclusive}
        regions = Regions(
            tuple(exclusive),
            space.point(np.array([s.position for s in exclusive.values()]).reshape(-1, 3)),
            np.array([site.radius_m for site in exclusive.values()]) / grid.cell_m,
        )
        self._others = {name: regions.without(name) for name in sites}
        self._goals = {name: site.position for name, site in sites.items()}
        goals = {name: space.point(goal) for name, goal in self._goals.items()}
        self._approaches = Approaches(goals, regions, space.free)

    def see(self, grid: OccupancyGrid) -> None:
        """The map from now on: same cells, but others of them are occupied."""
        before, self._space = self._space, FreeSpace(grid, self._is_inside, self._clearance_m)
        if not np.array_equal(before.free, self._space.free):
            self._approaches.see(self._space.free)
            self.version += 1

    def find(self, cells: int) -> bool:
        """Brings the ways to places up to date, in part; whether distances are quick to tell now.

        Args:
            cells: about so many are searched at most.
        """
        return self._approaches.find(cells)

    def aim(self, site: str, goal: Ned) -> None:
        """Routes to a site end here from now on; its region stays where it is."""
        if self._goals[site] != goal:
            self._goals[site] = goal
            self._approaches.aim(site, self._space.point(goal))

    def goal(self, site: str) -> Ned:
        """Where routes to a site end now."""
        return self._goals[site]

    def is_clear(self, path: npt.NDArray[np.float64]) -> bool:
        """Whether a path crosses free cells only; (n, 2) or (n, 3) metres.

        A path that begins in no free cell may lead out of there: until it comes to free cells it
        must come no closer to an obstacle than at its beginning, by a cell.
        """
        points = self._space.point(path)
        legs = self._space.is_clear(points[:-1], points[1:])
        if self._space.is_clear(points[0], points[0]):
            return bool(legs.all())
        return bool(self._space.keeps_away(points[0], points[1]) and legs[1:].all())

    def is_free(self, position: NorthEast) -> bool:
        """Whether a position has the clearance and lies inside the fence."""
        return self._space.is_free(self._space.grid.cell(position))

    def is_connected(self, start: NorthEast, site: str) -> bool:
        """Whether free cells lead from near a start to a site, whatever regions are on the way.

        Quick: where they do not, no field has to be made to know that there is no way.
        """
        goal = self._space.grid.cell(self._goals[site][:2])
        return self._space.is_connected(start, goal)

    def distance_m(self, start: NorthEast, site: str) -> float:
        """Length of the way along cells to a site, in the plane; inf if there is none.

        Raises:
            KeyError: there is no such site.
        """
        entry = self._entry(start, site)
        if entry is None:
            return math.inf
        (field, cell), grid = entry, self._space.grid
        goal = self._goals[site][:2]
        if field.cost[cell] == 0:
            return math.dist(start, goal)
        first = math.dist(start, grid.centre(*cell))
        last = math.dist(goal, grid.centre(*grid.cell(goal)))
        return first + float(field.cost[cell]) * grid.cell_m + last

    def route_from_motion(self, start: Ned, stop: Ned, site: str) -> Route | None:
        """A route whose first leg leads to where the vehicle can stop, straight ahead.

        None if that leg comes closer to an obstacle than the clearance and the start, by a cell, or
        if no way leads on from there; then a route from a start at rest is left, from which the
        vehicle deviates while it brakes.

        Args:
            start: where the vehicle is.
            stop: where it can come to rest.
            site: where to fly.
        """
        is_clear = self._space.keeps_away(self._space.point(start), self._space.point(stop))
        route = self.route(stop, site) if is_clear else None
        return Route(np.vstack([start, route.waypoints])) if route else None

    def route(self, start: Ned, site: str) -> Route | None:
        """The shortest route to a site, pulled tight; None if there is none.

        A start that is not free (the vehicle has drifted, or something has come near it) is left by
        a leg to the nearest free cell within ENTRY_M on whose way it comes no nearer to obstacles
        than it is; if there is none, to the nearest one across no occupied cell.

        Raises:
            KeyError: there is no such site.
        """
        entry = self._entry((start[0], start[1]), site)
        if entry is None:
            return None
        (field, cell), space = entry, self._space
        goal = self._goals[site]
        path = np.vstack([space.point(start), field.path(cell) + 0.5, space.point(goal)])
        held = 0 if space.is_clear(path[0], path[0]) else 1  # the leg out of the band
        legs = _Legs(space, self._others[site].around(path))
        points = np.vstack([path[:held], pulled_tight(path[held:], legs)])
        plane = points * space.grid.cell_m + space.grid.origin
        plane[0], plane[-1] = start[:2], goal[:2]  # exactly, whatever the rounding
        return Route(_with_altitude(plane, start[2], goal[2]))

    def _entry(self, start: NorthEast, site: str) -> tuple[Field, Cell] | None:
        """The field of a site and the cell by which a route begins; None if there is none."""
        field = self._approaches.field(site) if self.is_connected(start, site) else None
        cell = self._space.entry(start, self._others[site], field.cost) if field else None
        return (field, cell) if field and cell else None


@dataclass(frozen=True, slots=True)
class _Legs:
    """Legs across free cells that enter no other region (`taut.py`)."""

    space: FreeSpace
    others: Regions

    def may_be_clear(self, a: Points, b: Points) -> npt.NDArray[np.bool_]:
        return self.space.may_be_clear(a, b)

    def are_clear(self, a: Points, b: Points) -> npt.NDArray[np.bool_]:
        return self.space.is_clear(a, b) & ~self.others.are_entered(a, b)


def _with_altitude(
    plane: npt.NDArray[np.float64], first_down_m: float, last_down_m: float
) -> npt.NDArray[np.float64]:
    """(n, 3) waypoints of (n, 2) ones; down changes in proportion to the way in the plane."""
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(plane, axis=0), axis=1))])
    share = along / along[-1] if along[-1] > 0 else np.linspace(0.0, 1.0, len(plane))
    return np.column_stack([plane, first_down_m + share * (last_down_m - first_down_m)])
