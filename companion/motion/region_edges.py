"""The edges that enter regions, which paths to other places do not use.

They do not depend on which cells are free, so all clearances of a map share them.
"""

from __future__ import annotations

from functools import cached_property

from companion.motion.grid_graph import Cell, GridGraph, edges_entering, overlap, union
from companion.motion.regions import Regions


class RegionEdges:
    """The edges of a map that enter regions from outside; computed when first asked for.

    Args:
        shape: rows and columns of the map.
        regions: the regions of the exclusive places.

    Attributes:
        regions: see above.
    """

    def __init__(self, shape: Cell, regions: Regions) -> None:
        self.regions = regions
        self._shape = shape

    def barred_to(self, place: str) -> GridGraph:
        """The edges that no path to a place uses: those into the regions of all other places."""
        if place not in self._entering:
            return self._entering_any
        return self._entering_any.without(self._entering[place].without(self._entering_several))

    @cached_property
    def _entering(self) -> dict[str, GridGraph]:
        regions = self.regions
        return {name: edges_entering(self._shape, regions.only(name)) for name in regions.names}

    @cached_property
    def _entering_any(self) -> GridGraph:
        return union(self._entering.values(), self._shape)

    @cached_property
    def _entering_several(self) -> GridGraph:
        return overlap(self._entering.values(), self._shape)
