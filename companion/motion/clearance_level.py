"""Routes at one clearance: the cells that are free at it, and the cost-to-go of each place.

The vehicle may not be where its autopilot estimates it to be. So routes keep an added clearance
beyond the least one, where the map has room for it.

1. A passage that is too narrow is flown at the next lower clearance, in its middle (`voronoi.py`).
   Outside the passage the route still keeps what is enough.
2. If that leads nowhere, or is too long a detour, the whole route keeps only the level's clearance.
3. Levels differ by steps of the added clearance. clearance_choice.py decides which level is flown.

A place may itself be nearer to an obstacle than a level demands, and so may the vehicle. Around
each of them a disc is open in which routes keep as much distance as the place or the vehicle does.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from companion.geometry import Ned, NorthEast
from companion.motion.cost_to_go import CostToGo
from companion.motion.distance_maps import LOOK_SHARE, DistanceMaps
from companion.motion.free_space import FreeSpace
from companion.motion.grid import ROUNDING_M, OccupancyGrid
from companion.motion.grid_graph import Cell
from companion.motion.position_error import STEP_M
from companion.motion.region_edges import RegionEdges
from companion.motion.regions import Regions
from companion.motion.voronoi import passages

ENOUGH_SHARE = 2 / 3
"""The share of the added clearance that is enough if all of it makes a detour, see
`clearance_choice.py`."""

_MAX_STARTS = 1000  # starts whose cell is cached
_OPEN_SHARE = 1.5  # reach of an open disc, in straight ways out to the level's clearance


@dataclass(frozen=True, slots=True)
class Room:
    """What all levels have in common.

    Attributes:
        least_m: the least clearance of any route.
        is_inside: (rows, cols) cells inside the fence.
        edges: the edges into the regions of the exclusive places.
        others: by place, the regions of all other places, which a leg to it may not enter.
        goals: by place, where routes to it end; changed when symbols are aimed elsewhere.
    """

    least_m: float
    is_inside: npt.NDArray[np.bool_]
    edges: RegionEdges
    others: Mapping[str, Regions]
    goals: Mapping[str, Ned]


@dataclass(frozen=True, eq=False)
class Obstacles:
    """What routes keep away from.

    Attributes:
        grid: all obstacles as occupied cells, including keep-out zones.
        walls: (rows, cols) the solid obstacles among them.
        narrowest_m: width of the narrowest passage through which routes lead.
    """

    grid: OccupancyGrid
    walls: npt.NDArray[np.bool_]
    narrowest_m: float

    @cached_property
    def passages(self) -> npt.NDArray[np.bool_]:
        """(rows, cols) the cells in the middle of passages."""
        return passages(self.grid, self.narrowest_m)


class RouteEntry(NamedTuple):
    """Where a route to a place enters free cells.

    Attributes:
        to_go: the cost-to-go of the place.
        cell: the cell from which a path leads there.
        length_m: horizontal length of the whole route.
    """

    to_go: CostToGo
    cell: Cell
    length_m: float


class ClearanceLevel:
    """Routes at one clearance. Free cells and costs-to-go are computed when first asked for.

    Places whose goal has changed are updated only when somebody asks. Candidates for a goal may be
    many, most of them behind walls, and they are tried at the least clearance first.

    Attributes:
        clearance_m: the clearance of this level.

    Args:
        room: what all levels have in common.
        obstacles: the obstacles as known now.
        clearance_m: the clearance of this level.
        outside_m: clearance outside passages; None for the same as in them.
    """

    def __init__(
        self,
        room: Room,
        obstacles: Obstacles,
        clearance_m: float,
        outside_m: float | None = None,
    ) -> None:
        self._room = room
        self._obstacles = obstacles
        self.clearance_m = clearance_m
        self._outside_m = clearance_m if outside_m is None else outside_m
        self._aimed: set[str] = set()
        self._space: FreeSpace | None = None  # computed when first asked for
        self._plain: dict[NorthEast, Cell | None] = {}
        self._maps: DistanceMaps | None = None
        self._around: tuple[tuple[NorthEast, ...], FreeSpace] | None = None  # last result

    @property
    def space(self) -> FreeSpace:
        """The cells that are free now."""
        return self.look()

    @property
    def _is_looked_at(self) -> bool:
        """Whether the free cells are known for the present obstacles."""
        return self._space is not None and not self._aimed

    def look(self) -> FreeSpace:
        """Computes the free cells, unless they are known already."""
        self._follow_goals()
        if self._space is None:
            self._space = self._free_space()
        return self._space

    @property
    def maps(self) -> DistanceMaps:
        """The cost-to-go of all places."""
        self._follow_goals()
        if self._maps is None:
            points = {name: self.space.point(goal) for name, goal in self._room.goals.items()}
            self._maps = DistanceMaps(points, self._room.edges, self.space.free)
        return self._maps

    @property
    def _grid(self) -> OccupancyGrid:
        return self._obstacles.grid

    def see(self, obstacles: Obstacles) -> bool:
        """Takes over new obstacles on the same map; true if other cells are free now.

        If nobody has asked for the free cells yet, nothing changes for anybody.
        """
        self._follow_goals()
        self._obstacles = obstacles
        return self._take_free_space()

    def _take_free_space(self) -> bool:
        self._plain, self._around = {}, None
        if self._space is None:
            return False
        before, self._space = self._space, self._free_space()
        if np.array_equal(before.free, self._space.free):
            return False
        if self._maps is not None:
            self._maps.see(self._space.free)
        return True

    def aim(self, place: str) -> None:
        """Notes that the goal of a place has changed."""
        self._aimed.add(place)

    def _follow_goals(self) -> None:
        """Updates the places whose goal has changed."""
        if not self._aimed:
            return
        aimed, self._aimed = self._aimed, set()
        if self._outside_m > self._room.least_m:  # another disc is open now
            self._take_free_space()
        if self._maps is not None:
            for place in sorted(aimed):
                self._maps.aim(place, self.space.point(self._room.goals[place]))

    def above(self, added_m: float, outside_m: float | None = None) -> ClearanceLevel:
        """A level with more clearance on the same map, and perhaps still more outside passages."""
        least_m = self.clearance_m
        more_m = None if outside_m is None else least_m + outside_m
        return ClearanceLevel(self._room, self._obstacles, least_m + added_m, more_m)

    def around(self, *positions: NorthEast) -> FreeSpace:
        """The free cells with open discs around some positions; the last result is cached."""
        space = self.space
        if self._around is None or self._around[0] != positions:
            opened = self._opened(positions)
            made = space if opened is None else self._made(space.free | opened)
            self._around = positions, made
        return self._around[1]

    def repair(self, max_cells: int) -> bool:
        """Searches about `max_cells` cells for the places asked for at this clearance.

        True once their cost-to-go is current.
        """
        return self._maps is None or self.maps.find(max_cells, repairs_only=True)

    def search(self, start: NorthEast, place: str, max_cells: int) -> int:
        """Searches about `max_cells` cells for what `entry` needs; about how many it took."""
        used = 0
        if not self._is_looked_at:
            if max_cells <= 0:
                return 0
            used = int(LOOK_SHARE * self._grid.occupied.size)
        if not self.is_connected(start, place):
            return used
        return used + self.maps.search(place, max_cells - used, self._plain_cell(start))

    def is_known(self, start: NorthEast, place: str) -> bool:
        """Whether `entry` needs no further search."""
        if not self._is_looked_at:
            return False
        is_known = self.maps.is_known(place, self._plain_cell(start))
        return is_known or not self.is_connected(start, place)

    def is_connected(self, start: NorthEast, place: str) -> bool:
        """Whether free cells lead from near a start to a place, ignoring the regions in between."""
        goal = self._grid.cell(self._room.goals[place][:2])
        is_plain = self.space.is_connected(start, goal)
        return is_plain or self.around(start).is_connected(start, goal)

    def entry(self, start: NorthEast, place: str) -> RouteEntry | None:
        """Where a route to a place enters cells from which a path leads there; None without one."""
        return self.plain_entry(start, place) or self._entry_near(start, place)

    def plain_entry(self, start: NorthEast, place: str) -> RouteEntry | None:
        """The result of `entry`, quickly, if a path leads on from the start's own cell."""
        cell = self._plain_cell(start)
        goal = self._grid.cell(self._room.goals[place][:2])
        if cell is None or not self.space.are_connected(cell, goal):
            return None
        to_go = self.maps.cost_to_go(place, cell)
        is_way = to_go is not None and math.isfinite(to_go.cost[cell])
        return self._entered(start, place, to_go, cell) if to_go and is_way else None

    def _entry_near(self, start: NorthEast, place: str) -> RouteEntry | None:
        to_go = self.maps.cost_to_go(place) if self.is_connected(start, place) else None
        others = self._room.others[place]
        cell = self.around(start).entry(start, others, to_go.cost) if to_go else None
        return self._entered(start, place, to_go, cell) if to_go and cell else None

    def _entered(self, start: NorthEast, place: str, to_go: CostToGo, cell: Cell) -> RouteEntry:
        goal, grid = self._room.goals[place][:2], self._grid
        if to_go.cost[cell] == 0:
            return RouteEntry(to_go, cell, math.dist(start, goal))
        first = math.dist(start, grid.centre(*cell))
        last = math.dist(goal, grid.centre(*grid.cell(goal)))
        along = float(to_go.cost[cell]) * grid.cell_m
        return RouteEntry(to_go, cell, first + along + last)

    def _plain_cell(self, start: NorthEast) -> Cell | None:
        """Cached, because each place is a start of routes to all others."""
        if start not in self._plain:
            if len(self._plain) >= _MAX_STARTS:
                self._plain.clear()
            self._plain[start] = self.space.plain_cell(start, self._room.edges.regions)
        return self._plain[start]

    def _free_space(self) -> FreeSpace:
        away_m = self._grid.distance_m
        free = away_m >= self._outside_m
        if self._outside_m > self.clearance_m:
            free |= self._obstacles.passages & (away_m >= self.clearance_m)
        free &= ~self._grid.occupied & self._room.is_inside
        opened = self._opened([goal[:2] for goal in self._room.goals.values()])
        if opened is not None:
            free |= opened
        return self._made(free)

    def _made(self, free: npt.NDArray[np.bool_]) -> FreeSpace:
        walls = self._obstacles.walls
        return FreeSpace(self._grid, free, self._room.is_inside, self.clearance_m, walls)

    def _opened(self, positions: Iterable[NorthEast]) -> npt.NDArray[np.bool_] | None:
        """(rows, cols) open discs around those positions that need one; None if none does."""
        grid, opened = self._grid, None
        for position in positions:
            row, col = cell = grid.cell(position)
            own_m = float(grid.distance_m[cell]) if grid.contains(*cell) else 0.0
            if not self._room.least_m <= own_m < self._outside_m:
                continue
            reach = math.ceil(_OPEN_SHARE * (self._outside_m - own_m) / grid.cell_m)
            box = np.s_[
                max(row - reach, 0) : row + reach + 1, max(col - reach, 0) : col + reach + 1
            ]
            rows, cols = np.indices(grid.occupied[box].shape)
            north, east = rows + box[0].start - row, cols + box[1].start - col
            is_near = np.hypot(north, east) <= reach
            if opened is None:
                opened = np.zeros_like(grid.occupied)
            opened[box] |= is_near & (grid.distance_m[box] >= own_m)
        return opened & self._room.is_inside if opened is not None else None


def is_enough(kept_m: float, added_m: float) -> bool:
    """Whether the kept share of the added clearance is enough, so that no detour is made for more.

    >>> is_enough(0.4, 0.6), is_enough(0.3, 0.6)
    (True, False)
    """
    return kept_m >= ENOUGH_SHARE * added_m - ROUNDING_M


def levels_from(least: ClearanceLevel, added_m: float) -> list[ClearanceLevel]:
    """The levels up to the whole added clearance, the highest first.

    Below what is enough, each clearance has two levels: routes keep what is enough outside
    passages, or keep no more there than in passages. The last level is the least clearance itself.
    """
    count = round(added_m / STEP_M)
    steps = [added_m * i / count for i in range(count, 0, -1)] if count else []
    enough_m = min((step for step in steps if is_enough(step, added_m)), default=0.0)
    levels: list[ClearanceLevel] = []
    for kept_m in [*steps, 0.0]:
        if kept_m < enough_m:
            levels.append(least.above(kept_m, enough_m))
        levels.append(least.above(kept_m) if kept_m else least)
    return levels
