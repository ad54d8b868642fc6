"""The regions of places, which legs to other places may not enter.

A region is a disc or a polygon in the plane (`region.py`). A leg may leave it or stay inside, but
may not enter from outside. Points and radii are in cells (`line_of_sight.py`).

>>> regions = Regions(("A",), np.array([[5.0, 5.0]]), np.array([2.0]))
>>> bool(regions.are_entered(np.array([5.0, 1.0]), np.array([5.0, 4.0])))
True
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from itertools import compress

import numpy as np
import numpy.typing as npt

from companion.motion.line_of_sight import Points, enters_disc
from companion.motion.polygons import (
    are_inside,
    cells_beside,
    distance_to_edges,
    enters_polygon,
)


@dataclass(frozen=True, slots=True, eq=False)
class Regions:
    """The regions of some places.

    Attributes:
        names: names of the n places.
        centres: (n, 2).
        radii: (n,).
        polygons: by name, corners (m, 2) of regions that are not discs; centre and radius are those
            of a disc around them.
    """

    names: tuple[str, ...]
    centres: Points
    radii: npt.NDArray[np.float64]
    polygons: Mapping[str, Points] = field(default_factory=dict)

    def without(self, name: str) -> Regions:
        """The regions of all other places."""
        return self._chosen(np.array([other != name for other in self.names], dtype=np.bool_))

    def near(self, point: Points, reach: float) -> Regions:
        """The regions within a distance of a point, except those that contain it."""
        away = self.away(point)
        return self._chosen((away >= 0) & (away <= reach))

    def around(self, points: Points) -> Regions:
        """The regions that meet the bounding box of some points (n, 2)."""
        low, high = points.min(axis=0), points.max(axis=0)
        nearest = np.clip(self.centres, low, high)
        return self._chosen(np.hypot(*(self.centres - nearest).T) < self.radii)

    def away(self, point: Points) -> npt.NDArray[np.float64]:
        """(n,) distance of a point (2,) from each region; negative inside."""
        away = np.asarray(np.hypot(*(self.centres - point).T) - self.radii)
        for name, corners in self.polygons.items():
            gap = distance_to_edges(point, corners)
            away[self.names.index(name)] = -gap if are_inside(point, corners) else gap
        return away

    def are_entered(self, a: Points, b: Points) -> npt.NDArray[np.bool_]:
        """(...) whether legs from a to b (..., 2) enter one of the regions."""
        if not self.names:
            return np.zeros(np.broadcast_shapes(a.shape, b.shape)[:-1], dtype=np.bool_)
        is_disc = self._are_discs
        centres, radii = self.centres[is_disc], self.radii[is_disc]
        entered = np.any(enters_disc(a[..., None, :], b[..., None, :], centres, radii), axis=-1)
        for corners in self.polygons.values():
            entered |= enters_polygon(a, b, corners)
        return np.asarray(entered)

    def border(self, shape: tuple[int, ...], reach: int) -> npt.NDArray[np.int_]:
        """(k, 2) the cells of a map that include all ends of edges into a region.

        Args:
            shape: rows and columns of the map.
            reach: longest component of an edge, in cells.
        """
        low = np.maximum(np.floor(self.centres - self.radii[:, None]).astype(int) - reach, 0)
        high = np.ceil(self.centres + self.radii[:, None]).astype(int) + reach
        sizes = np.maximum(np.minimum(high, shape) - low, 0)
        boxes = zip(low[self._are_discs], sizes[self._are_discs], strict=True)
        found = [first + np.argwhere(np.ones(size)) for first, size in boxes]
        near = (cells_beside(shape, corners, reach + 1) for corners in self.polygons.values())
        return np.concatenate([*found, *map(np.argwhere, near), np.zeros((0, 2), dtype=int)])

    @property
    def _are_discs(self) -> npt.NDArray[np.bool_]:
        return np.array([name not in self.polygons for name in self.names], dtype=np.bool_)

    def only(self, name: str) -> Regions:
        """The region of one place."""
        return self._chosen(np.array([other == name for other in self.names], dtype=np.bool_))

    def _chosen(self, which: npt.NDArray[np.bool_]) -> Regions:
        names = tuple(compress(self.names, which.tolist()))
        polygons = {name: self.polygons[name] for name in names if name in self.polygons}
        return Regions(names, self.centres[which], self.radii[which], polygons)
