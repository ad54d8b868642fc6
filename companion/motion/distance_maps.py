"""Distance maps: the cost-to-go of every place on the map as it is known now.

The cost-to-go of a place (`cost_to_go.py`) is computed when it is first asked for. When it is asked
for after a change of the map, its last state is repaired. On a large map, or with many places, that
takes a while, so `search` and `find` do it in parts.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import numpy.typing as npt

from companion.motion.cost_to_go import ALL, CostToGo, adapted, begun, continued
from companion.motion.grid_graph import Cell, GridGraph, grid_graph
from companion.motion.line_of_sight import Points
from companion.motion.region_edges import RegionEdges
from companion.slices import spent

CELL_US = 0.4
"""About how long the search of a cell takes."""

LOOK_SHARE = 0.05
"""The time to look at a cell, as a share of the time to search it."""


class DistanceMaps:
    """The cost-to-go of each of several places.

    Args:
        goals: by place, (2,) the point at which paths to it end (`line_of_sight.py`).
        edges: edges that no path uses, except into the region of its own place.
        free: (rows, cols) the cells that are free at first.
    """

    def __init__(
        self, goals: Mapping[str, Points], edges: RegionEdges, free: npt.NDArray[np.bool_]
    ) -> None:
        self._goals = dict(goals)
        self._edges = edges
        self._former: dict[str, CostToGo] = {}
        self.see(free)

    def see(self, free: npt.NDArray[np.bool_]) -> None:
        """Takes over new free cells of the same map."""
        self._free = free
        self._graph: GridGraph | None = None  # made when a cost-to-go is asked for
        self._graph_elsewhere: GridGraph | None = None  # the same for all places without a region
        self._present: dict[str, CostToGo | None] = {}

    def aim(self, place: str, goal: Points) -> None:
        """Makes the paths to a place end at another point."""
        self._goals[place] = goal
        self._present.pop(place, None)
        self._former.pop(place, None)

    def find(self, max_cells: int, *, repairs_only: bool = False) -> bool:
        """Searches about `max_cells` cells of what is not known yet; True once everything is known.

        Args:
            repairs_only: whether to search only for those places that were asked for before.
        """
        for place in [*self._former] if repairs_only else self._goals:
            while not self.is_known(place):
                if max_cells <= 0:
                    return False
                max_cells -= self.search(place, max_cells)
        return True

    def is_known(self, place: str, cell: Cell | None = None) -> bool:
        """Whether the cost-to-go of a place, from a cell or from all, needs no further search."""
        if place not in self._present:
            return False
        to_go = self._present[place]
        return to_go is None or to_go.is_final(cell)

    def search(self, place: str, max_cells: int, cell: Cell | None = None) -> int:
        """Searches about `max_cells` cells for the cost-to-go of a place, from a cell or from all.

        Returns:
            About how many cells can be searched in the time that this took.

        Raises:
            KeyError: there is no such place.
        """
        used = 0
        if place not in self._present:
            self._present[place] = self._begun(place)
            used = int(LOOK_SHARE * self._free.size)
        to_go = self._present[place]
        if to_go is not None:
            now = continued(to_go, max(1, max_cells - used), cell)
            self._present[place] = self._former[place] = now
            used += now.searched - to_go.searched
        return used

    def cost_to_go(self, place: str, cell: Cell | None = None) -> CostToGo | None:
        """The cost-to-go of a place; None if the place cannot be reached from its own cell.

        If the search was interrupted, it is the cost-to-go on the map on which the search was
        begun.

        Args:
            place: one of the places.
            cell: the only cell whose path is needed, if any.

        Raises:
            KeyError: there is no such place.
        """
        if self.is_known(place, cell):
            return self._present[place]
        cells = self.search(place, ALL)
        found = self._present[place]
        spent(CELL_US * cells)
        return found

    def _begun(self, place: str) -> CostToGo | None:
        """The cost-to-go of a place on the present map, before the search."""
        goal = self._goals[place]
        row, col = np.floor(goal).astype(int).tolist()
        rows, cols = self._free.shape
        if not (0 <= row < rows and 0 <= col < cols and self._free[row, col]):
            return None
        centre = np.array((row + 0.5, col + 0.5))
        if self._edges.regions.without(place).are_entered(centre, goal):
            return None
        graph = self._allowed(place)
        former = self._former.get(place)
        return adapted(former, graph) if former else begun(graph, (row, col))

    def _allowed(self, place: str) -> GridGraph:
        """The edges that a path to a place may use; places without a region share one graph."""
        self._graph = self._graph or grid_graph(self._free)
        if place in self._edges.regions.names:
            return self._graph.without(self._edges.barred_to(place))
        if self._graph_elsewhere is None:
            self._graph_elsewhere = self._graph.without(self._edges.barred_to(place))
        return self._graph_elsewhere
