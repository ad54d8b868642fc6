"""Maps that a YAML file draws itself: an area with walls, without a map file.

1. The model `MapEntry` has the keys. Walls are polygons; a box has four corners.
2. If there is a fence, the area may be left out. It is then that of the fence, a little larger, and
   open: nothing is known to stand outside.
3. A drawn area has cells of 0.1 m. An open one may be large: its cells have the smallest size of
   `CELLS_M` that gives at most `MAX_OPEN_CELLS`. A file may give another size.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Annotated, Any

import numpy as np
from pydantic import BaseModel, BeforeValidator, ConfigDict, Field

from companion.errors import MissionError
from companion.geometry import FAR_M, NorthEast
from companion.maps import MANY, MAX_CELLS, MAX_EDGE_CELLS, check_cells
from companion.motion.grid import LowWalls, OccupancyGrid
from companion.motion.polygons import cells_of, cells_touched, problem_of, without_repeats

CELL_M = 0.1
CELLS_M = (0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0)
MAX_OPEN_CELLS = 250_000
"""Most cells of an open area: routes to one place are then found in a tenth of a second."""
RIM_M = 5.0
"""How far an open area extends beyond its fence, for what is seen there."""
_ROUNDING = 1e-9


def _pair(value: Any) -> Any:
    """Makes a tuple of a list, which strict validation demands for an optional key."""
    return tuple(value) if isinstance(value, list) else value


Metres = Annotated[float, Field(ge=-FAR_M, le=FAR_M)]
Span = Annotated[
    tuple[float, float],
    BeforeValidator(_pair, json_schema_input_type=tuple[float, float]),
    Field(description="[from, to], metres from home."),
]
Corner = Annotated[
    tuple[Metres, Metres], BeforeValidator(_pair, json_schema_input_type=tuple[Metres, Metres])
]


class DrawnModel(BaseModel):
    """A mapping of a YAML file; unknown keys are refused."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)


class WallEntry(DrawnModel):
    """An occupied box or polygon."""

    east_m: Annotated[Span | None, Field(description="Of a box: [from, to], metres.")] = None
    north_m: Annotated[Span | None, Field(description="Of a box: [from, to], metres.")] = None
    corners: Annotated[
        list[Corner] | None,
        Field(
            description="Of a polygon: [[east, north], ...], metres; in a mission with frame: "
            "wgs84 [[lat, lon], ...], degrees."
        ),
    ] = None
    up_m: Annotated[
        float | None,
        Field(
            gt=0,
            le=FAR_M,
            description="Upper end of the wall, metres above home, if the vehicle may fly over "
            "it; its lower end is on the ground. Without this key, the wall has no "
            "upper end.",
        ),
    ] = None


class MapEntry(DrawnModel):
    """An area with walls, instead of a map file."""

    east_m: Annotated[
        Span | None,
        Field(
            description="[from, to], metres from home; everything outside is occupied. Without "
            "east_m and north_m the area is that of the fence, and everything outside "
            "is free."
        ),
    ] = None
    north_m: Annotated[
        Span | None, Field(description="[from, to], metres from home; the same to the north.")
    ] = None
    cell_m: Annotated[
        float | None,
        Field(
            ge=0.01,
            le=100,
            description="Edge of a cell, metres. The default is 0.1, and more if the area is "
            "that of a large fence.",
        ),
    ] = None
    walls: Annotated[
        list[WallEntry],
        Field(
            description="Boxes and polygons: [{east_m: [4, 5], north_m: [0, 6]}, "
            "{corners: [[7, 0], [9, 0], [8, 3]]}, ...]."
        ),
    ] = []


@dataclass(frozen=True, slots=True)
class Wall:
    """An occupied part of a map.

    Attributes:
        corners: the corners of the polygon.
        up_m: its upper end above home; None for a wall without an upper end.
    """

    corners: tuple[NorthEast, ...]
    up_m: float | None = None

    def as_entry(self) -> dict[str, object]:
        """The wall as it is written in a file, in metres."""
        corners: dict[str, object] = {"corners": [[east, north] for north, east in self.corners]}
        return corners if self.up_m is None else corners | {"up_m": self.up_m}


ReadCorner = Callable[..., NorthEast]
"""Converts a corner in a file, given the keys that lead to it from the map's."""


def north_east(corner: Corner, *keys: str | int) -> NorthEast:
    """A corner [east, north], in metres."""
    east_m, north_m = corner
    return (north_m, east_m)


def walls_of(entry: MapEntry, read: ReadCorner = north_east) -> tuple[Wall, ...]:
    """The walls of a map.

    Args:
        entry: the map.
        read: converts the corners of polygons; boxes are in metres.

    Raises:
        MissionError: a wall is neither a box nor a polygon, or has no area.
    """
    return tuple(_wall(wall, read, i) for i, wall in enumerate(entry.walls))


def polygon(corners: Iterable[NorthEast], name: str) -> tuple[NorthEast, ...]:
    """A polygon from its corners.

    Args:
        corners: as they were read; the last one may repeat the first.
        name: the name of the polygon, for messages.

    Raises:
        MissionError: it has no area, or its edges cross.
    """
    found = without_repeats(tuple(corners))
    if problem := problem_of(found):
        hint = "go round it once, from corner to corner"
        raise MissionError(f"{name} is not a polygon: {problem}", hint=hint)
    return found


def _wall(entry: WallEntry, read: ReadCorner, number: int) -> Wall:
    spans = [span for span in (entry.east_m, entry.north_m) if span is not None]
    if len(spans) + 2 * (entry.corners is not None) != 2:
        hint = "write east_m and north_m for a box, or corners: [[east, north], ...]"
        raise MissionError("a wall of the map is neither a box nor a polygon", hint=hint)
    if entry.corners is not None:
        written = enumerate(entry.corners)
        corners = (read(corner, "walls", number, "corners", i) for i, corner in written)
        return Wall(polygon(corners, "a wall of the map"), entry.up_m)
    for first, last in spans:
        if not first < last:
            what = f"a wall of the map: {first:g} to {last:g} is not a range"
            raise MissionError(what, hint=f"write [{last:g}, {first:g}]: from, to")
    (west, east), (south, north) = spans
    return Wall(((south, west), (south, east), (north, east), (north, west)), entry.up_m)


def drawn_map(
    entry: MapEntry, walls: Iterable[Wall], fence: Sequence[NorthEast] | None = None
) -> OccupancyGrid:
    """The occupancy grid of an area with walls; a cell that a wall touches is occupied.

    >>> entry = MapEntry(east_m=(0, 4), north_m=(0, 2), cell_m=1.0)
    >>> room = drawn_map(entry, [Wall(((0.0, 1.0), (0.0, 2.0), (1.0, 2.0), (1.0, 1.0)))])
    >>> room.occupied.astype(int).tolist()
    [[0, 1, 0, 0], [0, 0, 0, 0]]

    Args:
        entry: its area and cells.
        walls: from `walls_of`.
        fence: corners of the fence, for an entry without an area.

    Raises:
        MissionError: there is no area, it is empty, or it has too many cells.
    """
    is_open = entry.east_m is None and entry.north_m is None
    east_m, north_m = entry.east_m, entry.north_m
    cell_m = entry.cell_m or CELL_M
    if is_open and fence is not None:
        east_m, north_m = _around(fence, 1), _around(fence, 0)
        cell_m = entry.cell_m or _open_cell_m(east_m[1] - east_m[0], north_m[1] - north_m[0])
    spans = {"east_m": east_m, "north_m": north_m}
    fits = _fitting_cell_m([span for span in spans.values() if span is not None])
    (west, cols), (south, rows) = (_cells(key, spans[key], cell_m, fits) for key in spans)
    check_cells(cols, rows, fits)
    empty = OccupancyGrid(np.zeros((rows, cols), dtype=np.bool_), cell_m, (south, west), is_open)
    return walled(empty, walls)


def walled(grid: OccupancyGrid, walls: Iterable[Wall]) -> OccupancyGrid:
    """A grid without low walls, with walls added."""
    walls = tuple(walls)
    high = cells_of(grid, (wall.corners for wall in walls if wall.up_m is None))
    low = [wall for wall in walls if wall.up_m is not None]
    if not low:
        return high
    tops_m = np.zeros(grid.occupied.shape)
    for wall in low:
        points = (np.array(wall.corners) - grid.origin) / grid.cell_m
        height_m = np.where(cells_touched(tops_m.shape, points), wall.up_m or 0.0, 0.0)
        tops_m = np.maximum(tops_m, height_m)
    return replace(high, low=LowWalls(tops_m))


def _around(fence: Sequence[NorthEast], axis: int) -> tuple[float, float]:
    """The range of a fence's area along an axis."""
    metres = [corner[axis] for corner in fence]
    return min(metres) - RIM_M, max(metres) + RIM_M


def _open_cell_m(*edges_m: float) -> float:
    """The cell size of an open area."""
    fits = (c for c in CELLS_M if math.prod(math.ceil(e / c) for e in edges_m) <= MAX_OPEN_CELLS)
    return next(fits, CELLS_M[-1])


def _fitting_cell_m(spans: Sequence[tuple[float, float]]) -> str:
    """Advice for an area with too many cells."""
    edges_m = [last - first for first, last in spans]

    def is_allowed(cell_m: float) -> bool:
        cells = [math.ceil(min(edge_m / cell_m, MANY)) for edge_m in edges_m]
        return max(cells, default=0) <= MAX_EDGE_CELLS and math.prod(cells) <= MAX_CELLS

    fits = next(filter(is_allowed, CELLS_M), None)
    return f"write cell_m: {fits:g}, or more" if fits else "write a smaller area"


def _cells(
    key: str, span: tuple[float, float] | None, cell_m: float, remedy: str
) -> tuple[float, int]:
    """The start of an area's cells along an axis, and their number."""
    if span is None:
        hint = "write east_m and north_m: [from, to], or neither: then it is that of the fence"
        raise MissionError(f"the map has no {key}", hint=hint)
    first, last = span
    if not first < last:
        hint = f"write [{last:g}, {first:g}]: from, to"
        raise MissionError(f"{key} of the map: {first:g} to {last:g} is not a range", hint=hint)
    needed = (last - first) / cell_m - _ROUNDING
    if needed > MAX_EDGE_CELLS:
        what = f"{key} of the map: {math.ceil(min(needed, MANY))} cells are too many"
        raise MissionError(what, hint=f"at most {MAX_EDGE_CELLS} along an edge: {remedy}")
    return first, math.ceil(needed)
