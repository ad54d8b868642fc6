"""Routes at one clearance: the cells that are free at it, and the cost-to-go of each place.

The vehicle may be off from where its autopilot takes it to be. So routes keep more than the least
clearance, where the map has room for that; a passage that is too narrow is flown at the next lower
one, in its middle (`voronoi.py`), and only the passage: outside it the way keeps what is enough.
Where that leads nowhere, or round a corner that is not worth it, all of the way keeps no more than
the level's clearance. Levels are a step of what is added apart; at which one a place is flown to,
way_choice.py says.

A place may itself stand nearer to an obstacle than a level asks for, and so may the vehicle. Around
each a disc is open in which routes keep as much as the place, or the vehicle, does.
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
"""Of what is added; where all of it would be a longer way still (`way_choice.py`)."""

_MAX_STARTS = 1000  # of which the cell is kept
_OPEN_SHARE = 1.5  # reach of an open disc, of the way straight out to the level's clearance


@dataclass(frozen=True, slots=True)
class Room:
    """What all levels share.

    Attributes:
        least_m: the clearance that no route goes below.
        is_inside: (rows, cols) cells that the fence holds.
        edges: into the regions of the exclusive places.
        others: by place, the regions of all others, which a leg to it may not enter.
        goals: by place, where routes to it end; changed where symbols are aimed elsewhere.
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
        grid: on which all of it is occupied, keep-out zones as well.
        walls: (rows, cols) what is solid of it.
        narrowest_m: width of the narrowest passage that is flown through.
    """

    grid: OccupancyGrid
    walls: npt.NDArray[np.bool_]
    narrowest_m: float

    @cached_property
    def passages(self) -> npt.NDArray[np.bool_]:
        """(rows, cols) the cells in the middle of a passage."""
        return passages(self.grid, self.narrowest_m)


class WayEntry(NamedTuple):
    """Where a way to a place enters free cells.

    Attributes:
        to_go: the cost-to-go of the place.
        cell: from which a way leads there.
        length_m: of the whole way, in the plane.
    """

    to_go: CostToGo
    cell: Cell
    length_m: float


class ClearanceLevel:
    """Routes at one clearance. Free cells and costs-to-go are found when first asked for.

    Places whose goal has changed are seen to when somebody looks: candidates for a goal that lie
    behind walls are many, and tried at the least clearance first.

    Attributes:
        clearance_m: of this level.

    Args:
        room: what all levels share.
        obstacles: as they are known now.
        clearance_m: see above.
        outside_m: what is kept outside passages; None for no more than in them.
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
        self._space: FreeSpace | None = None  # until somebody looks
        self._plain: dict[NorthEast, Cell | None] = {}
        self._maps: DistanceMaps | None = None
        self._around: tuple[tuple[NorthEast, ...], FreeSpace] | None = None  # asked for last

    @property
    def space(self) -> FreeSpace:
        """The free cells now."""
        return self.look()

    @property
    def _is_looked_at(self) -> bool:
        """Whether the free cells are known as they are now."""
        return self._space is not None and not self._aimed

    def look(self) -> FreeSpace:
        """Finds the free cells, if nobody has looked at them yet."""
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
        """Takes over other obstacles on the same map; true if other cells are free now.

        Where nobody has looked yet, nobody knows others.
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
        """The goal of a place has changed."""
        self._aimed.add(place)

    def _follow_goals(self) -> None:
        """Sees to the places whose goal has changed."""
        if not self._aimed:
            return
        aimed, self._aimed = self._aimed, set()
        if self._outside_m > self._room.least_m:  # another disc is open
            self._take_free_space()
        if self._maps is not None:
            for place in sorted(aimed):
                self._maps.aim(place, self.space.point(self._room.goals[place]))

    def above(self, added_m: float, outside_m: float | None = None) -> ClearanceLevel:
        """A level of a greater clearance on the same map; more may be added outside passages."""
        least_m = self.clearance_m
        more_m = None if outside_m is None else least_m + outside_m
        return ClearanceLevel(self._room, self._obstacles, least_m + added_m, more_m)

    def around(self, *positions: NorthEast) -> FreeSpace:
        """The free cells with open discs around some positions; those asked for last are kept."""
        space = self.space
        if self._around is None or self._around[0] != positions:
            opened = self._opened(positions)
            made = space if opened is None else self._made(space.free | opened)
            self._around = positions, made
        return self._around[1]

    def repair(self, max_cells: int) -> bool:
        """Searches about `max_cells` cells for the places that were looked for at this clearance.

        True once their cost-to-go is current.
        """
        return self._maps is None or self.maps.find(max_cells, repairs_only=True)

    def search(self, start: NorthEast, place: str, max_cells: int) -> int:
        """Searches about `max_cells` cells for what `entry` asks for; about how many it took."""
        used = 0
        if not self._is_looked_at:
            if max_cells <= 0:
                return 0
            used = int(LOOK_SHARE * self._grid.occupied.size)
        if not self.is_connected(start, place):
            return used
        return used + self.maps.search(place, max_cells - used, self._plain_cell(start))

    def is_known(self, start: NorthEast, place: str) -> bool:
        """Whether `entry` needs no search any more."""
        if not self._is_looked_at:
            return False
        is_known = self.maps.is_known(place, self._plain_cell(start))
        return is_known or not self.is_connected(start, place)

    def is_connected(self, start: NorthEast, place: str) -> bool:
        """Whether free cells lead from near a start to a place, whatever regions lie between."""
        goal = self._grid.cell(self._room.goals[place][:2])
        is_plain = self.space.is_connected(start, goal)
        return is_plain or self.around(start).is_connected(start, goal)

    def entry(self, start: NorthEast, place: str) -> WayEntry | None:
        """Where a way to a place enters the cells from which there is one; None without any."""
        return self.plain_entry(start, place) or self._entry_near(start, place)

    def plain_entry(self, start: NorthEast, place: str) -> WayEntry | None:
        """The same, quickly, for a start from whose own cell a path leads on; else None."""
        cell = self._plain_cell(start)
        goal = self._grid.cell(self._room.goals[place][:2])
        if cell is None or not self.space.are_connected(cell, goal):
            return None
        to_go = self.maps.cost_to_go(place, cell)
        is_way = to_go is not None and math.isfinite(to_go.cost[cell])
        return self._entered(start, place, to_go, cell) if to_go and is_way else None

    def _entry_near(self, start: NorthEast, place: str) -> WayEntry | None:
        to_go = self.maps.cost_to_go(place) if self.is_connected(start, place) else None
        others = self._room.others[place]
        cell = self.around(start).entry(start, others, to_go.cost) if to_go else None
        return self._entered(start, place, to_go, cell) if to_go and cell else None

    def _entered(self, start: NorthEast, place: str, to_go: CostToGo, cell: Cell) -> WayEntry:
        goal, grid = self._room.goals[place][:2], self._grid
        if to_go.cost[cell] == 0:
            return WayEntry(to_go, cell, math.dist(start, goal))
        first = math.dist(start, grid.centre(*cell))
        last = math.dist(goal, grid.centre(*grid.cell(goal)))
        along = float(to_go.cost[cell]) * grid.cell_m
        return WayEntry(to_go, cell, first + along + last)

    def _plain_cell(self, start: NorthEast) -> Cell | None:
        """Kept, since each place is a start of routes to all others."""
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
        """(rows, cols) open discs around those positions that need one; None without any."""
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
    """Whether so much of what is added is kept that no longer way is flown for the rest.

    >>> is_enough(0.4, 0.6), is_enough(0.3, 0.6)
    (True, False)
    """
    return kept_m >= ENOUGH_SHARE * added_m - ROUNDING_M


def levels_from(least: ClearanceLevel, added_m: float) -> list[ClearanceLevel]:
    """The levels at which routes keep up to so much more than the least, the highest first.

    Below what is enough there are two of each clearance: outside passages what is enough is kept,
    or no more than in them. The last one is the least itself.
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
