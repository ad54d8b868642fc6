"""The middle of every passage: the generalised Voronoi diagram of a map.

A cell is on the diagram if two neighbours have different nearest obstacles (Takahashi and Schilling
1989, Motion planning in a plane using generalized Voronoi diagrams). Beside a single wall these are
at most a cell apart. In a passage they are on opposite sides, as far apart as the passage is wide.
So the diagram leads through the middle of each passage, and out at both ends. Cells have to be
small against the clearance: a passage of fewer than four cells cannot be told from a wall.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from scipy import ndimage

from companion.motion.grid import OccupancyGrid, dilated

_ROUNDING_CELLS = 3.0
"""By how much two thickened walls are nearer to each other than their edges, with a margin."""


def passages(grid: OccupancyGrid, wide_m: float) -> npt.NDArray[np.bool_]:
    """(rows, cols) cells of the diagram in passages of at least this width, and their neighbours.

    Outside a grid that is not open everything is an obstacle.

    Args:
        grid: the map.
        wide_m: width of the narrowest passage.
    """
    padded = np.pad(grid.occupied, 1, constant_values=not grid.is_open)
    if not padded.any():
        return np.zeros_like(grid.occupied)
    nearest = ndimage.distance_transform_edt(
        ~dilated(padded), return_distances=False, return_indices=True
    )
    apart = max(wide_m / grid.cell_m - _ROUNDING_CELLS, _ROUNDING_CELLS)
    is_between = np.zeros_like(padded)
    for axis in (0, 1):
        gap = np.diff(nearest, axis=axis + 1)
        is_wide = (gap[0] ** 2 + gap[1] ** 2) >= apart**2
        here, there = (_all_but(end, axis) for end in (-1, 0))
        is_between[here] |= is_wide
        is_between[there] |= is_wide
    return np.asarray(dilated(is_between)[1:-1, 1:-1])


def _all_but(end: int, axis: int) -> tuple[slice, slice]:
    """All rows or columns except the last one, or the first one."""
    part = slice(None, -1) if end == -1 else slice(1, None)
    return (part, slice(None)) if axis == 0 else (slice(None), part)
