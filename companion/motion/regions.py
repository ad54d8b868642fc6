"""Does a leg come into the region of a place that it does not lead to?

A region is a disc in the plane. A leg may leave it, and lead on inside; it may not come in from
outside. Centres and radii are in cells (`sight.py`).
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import compress

import numpy as np
import numpy.typing as npt

from companion.motion.sight import Points, enters


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
        """Those of the other places."""
        return self._chosen(np.array([other != name for other in self.names], dtype=np.bool_))

    def near(self, point: Points, reach: float) -> Regions:
        """Those that a leg from a point can come into within a reach: not those that it is in."""
        away = self.away(point)
        return self._chosen((away >= 0) & (away <= reach))

    def around(self, points: Points) -> Regions:
        """Those that legs between some points (n, 2) can come to."""
        low, high = points.min(axis=0), points.max(axis=0)
        nearest = np.clip(self.centres, low, high)
        return self._chosen(np.hypot(*(self.centres - nearest).T) < self.radii)

    def away(self, point: Points) -> npt.NDArray[np.float64]:
        """(n,) how far a point (2,) is from each of them; negative inside."""
        return np.asarray(np.hypot(*(self.centres - point).T) - self.radii)

    def are_entered(self, a: Points, b: Points) -> npt.NDArray[np.bool_]:
        """(...) whether legs from a to b (..., 2) come into one of them."""
        if not self.names:
            return np.zeros(np.broadcast_shapes(a.shape, b.shape)[:-1], dtype=np.bool_)
        entered = enters(a[..., None, :], b[..., None, :], self.centres, self.radii)
        return np.asarray(np.any(entered, axis=-1))

    def _chosen(self, which: npt.NDArray[np.bool_]) -> Regions:
        names = tuple(compress(self.names, which.tolist()))
        return Regions(names, self.centres[which], self.radii[which])
