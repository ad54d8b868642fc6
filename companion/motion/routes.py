"""Routes on the map: how far is it to a place, and along which straight legs?

A cell is free if the next obstacle is at least the clearance away and the fence holds all of
the cell. One field per place gives the way along free cells from everywhere (`fields.py`); the
route is that way pulled tight by legs that cross free cells only (`sight.py`).

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
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy import ndimage

from companion.geometry import Ned, NorthEast
from companion.motion.fields import Cell, Field, MoveGraph
from companion.motion.grid import OccupancyGrid, cells_inside
from companion.motion.sight import Points, Sight, enters
from companion.motion.taut import length, pulled_tight

ENTRY_M = 1.0  # how far from the nearest free cell a route may begin (tracking error)

_EDGE = 1e-6  # cells; nearer to the edge of a cell a leg might touch the next one
_MOST_VIEWS = 256


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


class _View(NamedTuple):
    """The free cells that a leg leads to from a start.

    Attributes:
        is_free: the start has the clearance; if not, legs out of there keep clear of walls alone.
        cells: (n, 2) nearest first.
    """

    is_free: bool
    cells: npt.NDArray[np.int_]


class RouteMap:
    """Routes and distances to places on the map as it is known now.

    Each place's field is computed when it is first asked for, and kept until the map changes. With
    many places that takes a while after a change; `find` does it in small parts.

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
        self._sites = dict(sites)
        self._goals = {name: site.position for name, site in sites.items()}
        self._clearance_m = clearance_m
        self._is_inside = cells_inside(grid, fence)
        self._use(grid, self._free_on(grid))

    def see(self, grid: OccupancyGrid) -> None:
        """The map from now on: same cells, but others of them are occupied."""
        free = self._free_on(grid)
        if np.array_equal(free, self._free):
            self._grid, self._open_sight = grid, Sight(~grid.occupied)
            self._views.clear()
        else:
            self._use(grid, free)
            self.version += 1

    def _free_on(self, grid: OccupancyGrid) -> npt.NDArray[np.bool_]:
        return np.asarray((grid.distance_m >= self._clearance_m) & self._is_inside)

    def _use(self, grid: OccupancyGrid, free: npt.NDArray[np.bool_]) -> None:
        self._grid = grid
        self._free: npt.NDArray[np.bool_] = free
        self._free_sight = Sight(free)
        self._open_sight = Sight(~grid.occupied)
        self._graph: MoveGraph | None = None  # made when a field is asked for
        self._parts = ndimage.label(free)[0]
        self._fields: dict[str, Field | None] = {}
        self._views: dict[NorthEast, _View] = {}

    def find(self, count: int) -> bool:
        """Computes fields that have not been yet, at most so many; whether there are no more."""
        missing = [site for site in self._sites if site not in self._fields]
        for site in missing[:count]:
            self._field(site)
        return len(missing) <= count

    def aim(self, site: str, goal: Ned) -> None:
        """Routes to a site end here from now on; its region stays where it is."""
        if self._goals[site] != goal:
            self._goals[site] = goal
            self._fields.pop(site, None)

    def goal(self, site: str) -> Ned:
        """Where routes to a site end now."""
        return self._goals[site]

    def is_clear(self, path: npt.NDArray[np.float64]) -> bool:
        """Whether a path crosses free cells only; (n, 2) or (n, 3) metres.

        A path that begins in no free cell may lead out of there: until it comes to free cells it
        must come no closer to an obstacle than at its beginning, by a cell.
        """
        points = self._point(path)
        legs = self._free_sight.is_clear(points[:-1], points[1:])
        if self._free_sight.is_clear(points[0], points[0]):
            return bool(legs.all())
        return bool(self._keeps_away(points[0], points[1]) and legs[1:].all())

    def is_free(self, position: NorthEast) -> bool:
        """Whether a position has the clearance and lies inside the fence."""
        return self._is_free_cell(self._grid.cell(position))

    def is_connected(self, start: NorthEast, site: str) -> bool:
        """Whether free cells lead from near a start to a site, whatever regions are on the way.

        Quick: where they do not, no field has to be made to know that there is no way.
        """
        goal = self._grid.cell(self._goals[site][:2])
        if not self._is_free_cell(goal):
            return False
        return bool(np.any(self._parts[self._near(self._grid.cell(start))] == self._parts[goal]))

    def distance_m(self, start: NorthEast, site: str) -> float:
        """Length of the way along cells to a site, in the plane; inf if there is none.

        Raises:
            KeyError: there is no such site.
        """
        entry = self._entry(start, site)
        if entry is None:
            return math.inf
        field, cell = entry
        goal = self._goals[site][:2]
        if field.cost[cell] == 0:
            return math.dist(start, goal)
        first = math.dist(start, self._grid.centre(*cell))
        last = math.dist(goal, self._grid.centre(*self._grid.cell(goal)))
        return first + float(field.cost[cell]) * self._grid.cell_m + last

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
        is_clear = self._keeps_away(self._point(start), self._point(stop))
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
        field, cell = entry
        goal = self._goals[site]
        path = np.vstack([self._point(start), field.path(cell) + 0.5, self._point(goal)])
        held = 0 if self._free_sight.is_clear(path[0], path[0]) else 1  # the leg out of the band
        tight = pulled_tight(path[held:], lambda a, b: self._is_leg(a, b, site))
        points = np.vstack([path[:held], tight])
        plane = points * self._grid.cell_m + self._grid.origin
        plane[0], plane[-1] = start[:2], goal[:2]  # exactly, whatever the rounding
        return Route(_with_altitude(plane, start[2], goal[2]))

    def _keeps_away(self, a: Points, b: Points) -> bool:
        """Whether a leg comes no closer to an obstacle than the clearance and its start, by a cell.

        It leaves the fence only if it begins outside.
        """
        way = np.linspace(a, b, 2 + int(2 * math.dist(a, b)))
        cells = np.clip(np.floor(way).astype(int), 0, np.array(self._free.shape) - 1)
        away_m = self._grid.distance_m[cells[:, 0], cells[:, 1]]
        is_inside = self._is_inside[cells[:, 0], cells[:, 1]]
        least_m = min(away_m[0], self._clearance_m) - self._grid.cell_m
        is_kept = away_m.min() >= least_m and (is_inside.all() or not is_inside[0])
        return bool(is_kept and self._open_sight.is_clear(a, b))

    def _point(self, positions: npt.ArrayLike) -> Points:
        """Positions, given by north, east and perhaps down, in units of cells (`sight.py`)."""
        plane = np.asarray(positions, dtype=np.float64)[..., :2]
        return np.asarray((plane - self._grid.origin) / self._grid.cell_m)

    def _is_free_cell(self, cell: Cell) -> bool:
        return self._grid.contains(*cell) and bool(self._free[cell])

    def _others(self, site: str) -> list[Site]:
        """The places whose regions no route to a site may enter."""
        return [other for name, other in self._sites.items() if other.is_exclusive and name != site]

    def _is_leg(self, a: Points, b: Points, site: str) -> npt.NDArray[np.bool_]:
        """(...) whether legs (..., 2) on the way to a site are clear, and enter no other region."""
        return self._free_sight.is_clear(a, b) & self._is_allowed(a, b, site)

    def _is_allowed(self, a: Points, b: Points, site: str) -> npt.NDArray[np.bool_]:
        """(...) whether legs (..., 2) on the way to a site enter no other region."""
        return self._are_outside(a, b, self._others(site))

    def _are_outside(self, a: Points, b: Points, others: list[Site]) -> npt.NDArray[np.bool_]:
        """(...) whether legs (..., 2) enter none of some regions."""
        centres = self._point(np.array([other.position for other in others]).reshape(-1, 3))
        radii = np.array([other.radius_m for other in others]) / self._grid.cell_m
        entered = enters(a[..., None, :], b[..., None, :], centres, radii)
        return np.asarray(~np.any(entered, axis=-1))

    def _field(self, site: str) -> Field | None:
        """The field of a site; None if the site itself cannot be reached from its own cell."""
        if site not in self._fields:
            self._fields[site] = self._searched(site)
        return self._fields[site]

    def _searched(self, site: str) -> Field | None:
        position = self._goals[site]
        cell = self._grid.cell((position[0], position[1]))
        if not self._is_free_cell(cell):
            return None
        if not self._is_allowed(_centre(cell), self._point(position), site):
            return None
        graph = self._graph = self._graph or MoveGraph(self._free)
        entering = [
            graph.entering(self._point(other.position), other.radius_m / self._grid.cell_m)
            for other in self._others(site)
        ]
        return graph.field(cell, np.concatenate([np.empty(0, dtype=np.int_), *entering]))

    def _entry(self, start: NorthEast, site: str) -> tuple[Field, Cell] | None:
        """The nearest cell to which a leg leads and from which there is a way to a site."""
        field = self._field(site) if self.is_connected(start, site) else None
        if field is None:
            return None
        own_cell = self._grid.cell(start)
        if self._is_plain(start, own_cell, site) and math.isfinite(field.cost[own_cell]):
            return field, own_cell
        view, point = self._view(start, own_cell), self._point(start)
        cells = view.cells[np.isfinite(field.cost[view.cells[:, 0], view.cells[:, 1]])]
        others = [other for other in self._others(site) if self._is_near(start, other)]
        if others:
            centres = cells.astype(np.float64) + 0.5
            cells = cells[self._are_outside(point, centres, others)]
        if not len(cells):
            return None
        entry = cells[0]
        if not view.is_free:
            entry = next((cell for cell in cells if self._keeps_away(point, cell + 0.5)), entry)
        row, col = entry.tolist()
        return field, (row, col)

    def _view(self, start: NorthEast, own_cell: Cell) -> _View:
        """What is seen from a start; kept, since each place is a start on the way to all others."""
        if start not in self._views:
            point = self._point(start)
            is_free = bool(self._free_sight.is_clear(point, point))
            sight = self._free_sight if is_free else self._open_sight
            near = self._near(own_cell)
            cells = np.argwhere(self._free[near]) + [axis.start for axis in near]
            away = np.linalg.norm(cells - np.array(own_cell), axis=1)
            usable = (away <= ENTRY_M / self._grid.cell_m) & sight.is_clear(point, cells + 0.5)
            if len(self._views) >= _MOST_VIEWS:
                self._views.clear()
            nearest = np.argsort(away[usable], kind="stable")
            self._views[start] = _View(is_free, cells[usable][nearest])
        return self._views[start]

    def _is_near(self, start: NorthEast, other: Site) -> bool:
        """Whether a leg to an entry may come to a region."""
        away_m = math.dist(start, other.position[:2]) - other.radius_m
        return away_m <= ENTRY_M + self._grid.cell_m

    def _near(self, cell: Cell) -> tuple[slice, slice]:
        """The cells within ENTRY_M of one along each axis."""
        reach = ENTRY_M / self._grid.cell_m
        row, col = (
            slice(max(math.floor(x - reach), 0), max(math.ceil(x + reach) + 1, 0)) for x in cell
        )
        return row, col

    def _is_plain(self, start: NorthEast, cell: Cell, site: str) -> bool:
        """Whether a start is well inside a free cell, and at no border of a region.

        Its leg to the centre of the cell is then clear, and enters no region that it was not in.
        Most starts are plain, and the test is quick.
        """
        if not self._is_free_cell(cell):
            return False
        cell_m = self._grid.cell_m
        row, col = ((x - o) / cell_m for x, o in zip(start, self._grid.origin, strict=True))
        if not (_EDGE < row - cell[0] < 1 - _EDGE and _EDGE < col - cell[1] < 1 - _EDGE):
            return False
        north, east = start
        for name, other in self._sites.items():
            if other.is_exclusive and name != site:
                outside_m = math.hypot(other.position[0] - north, other.position[1] - east)
                if -_EDGE <= outside_m - other.radius_m <= cell_m:
                    return False
        return True


def _centre(cell: Cell) -> Points:
    return np.array(cell) + 0.5


def _with_altitude(
    plane: npt.NDArray[np.float64], first_down_m: float, last_down_m: float
) -> npt.NDArray[np.float64]:
    """(n, 3) waypoints of (n, 2) ones; down changes in proportion to the way in the plane."""
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(plane, axis=0), axis=1))])
    share = along / along[-1] if along[-1] > 0 else np.linspace(0.0, 1.0, len(plane))
    return np.column_stack([plane, first_down_m + share * (last_down_m - first_down_m)])
