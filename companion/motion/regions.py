"""The regions of places, which legs to other places may not enter.

A region is a disc in the plane. A leg may leave it, or stay inside; it may not come in from
outside. Centres and radii are in cells (`line_of_sight.py`).

>>> regions = Regions(("A",), np.array([[5.0, 5.0]]), np.array([2.0]))
>>> bool(regions.are_entered(np.array([5.0, 1.0]), np.array([5.0, 4.0])))
True
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import compress

import numpy as np
import numpy.typing as npt

from companion.motion.line_of_sight import Points, enters_disc


@dataclass(frozen=True, slots=True, eq=False)
class Regions:
    """The regions of some places.

    Attributes:
        names: n names of the places.
        centres: (n, 2).
        radii: (n,).
    """

    names: tuple[str, ...]
    centres: Points
    radii: npt.NDArray[np.float64]

    def without(self, name: str) -> Regions:
        """The regions of all other places."""
        return self._chosen(np.array([other != name for other in self.names], dtype=np.bool_))

    def near(self, point: Points, reach: float) -> Regions:
        """The regions within a distance of a point, without those that hold it."""
        away = self.away(point)
        return self._chosen((away >= 0) & (away <= reach))

    def around(self, points: Points) -> Regions:
        """The regions that meet the bounding box of some points (n, 2)."""
        low, high = points.min(axis=0), points.max(axis=0)
        nearest = np.clip(self.centres, low, high)
        return self._chosen(np.hypot(*(self.centres - nearest).T) < self.radii)

    def away(self, point: Points) -> npt.NDArray[np.float64]:
        """(n,) distance of a point (2,) from each region; negative inside."""
        return np.asarray(np.hypot(*(self.centres - point).T) - self.radii)

    def are_entered(self, a: Points, b: Points) -> npt.NDArray[np.bool_]:
        """(...) whether legs from a to b (..., 2) enter one of the regions."""
        if not self.names:
            return np.zeros(np.broadcast_shapes(a.shape, b.shape)[:-1], dtype=np.bool_)
        entered = enters_disc(a[..., None, :], b[..., None, :], self.centres, self.radii)
        return np.asarray(np.any(entered, axis=-1))

    def _chosen(self, which: npt.NDArray[np.bool_]) -> Regions:
        names = tuple(compress(self.names, which.tolist()))
        return Regions(names, self.centres[which], self.radii[which])
