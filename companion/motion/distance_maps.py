"""Distance maps: the cost-to-go of every place on the map as it is known now.

The cost-to-go of a place (`cost_to_go.py`) is computed when it is first asked for. When it is
asked for after a change of the map, it is repaired from its last state. With many places that
takes a while, so `find` does it in parts.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import numpy.typing as npt

from companion.motion.cost_to_go import CostToGo, cost_to_go, repaired
from companion.motion.grid_graph import GridGraph, edges_entering, grid_graph, union
from companion.motion.line_of_sight import Points
from companion.motion.regions import Regions

_REPAIR_OVERHEAD = 2000  # cells that a search covers in the time that the smallest repair takes


class DistanceMaps:
    """The cost-to-go of each of several places.

    Args:
        goals: by place, (2,) the point where paths to it end (`line_of_sight.py`).
        regions: no path enters one of these, except the region of its own place.
        free: (rows, cols) the free cells at first.
    """

    def __init__(
        self, goals: Mapping[str, Points], regions: Regions, free: npt.NDArray[np.bool_]
    ) -> None:
        self._goals = dict(goals)
        self._regions = regions
        discs = zip(regions.names, regions.centres, regions.radii, strict=True)
        self._entering = {name: edges_entering(free.shape, *disc) for name, *disc in discs}
        self._barred: dict[str, GridGraph] = {}
        self._outdated: dict[str, CostToGo] = {}
        self.see(free)

    def see(self, free: npt.NDArray[np.bool_]) -> None:
        """Takes over other free cells of the same map."""
        self._free = free
        self._graph: GridGraph | None = None  # made when a cost-to-go is asked for
        self._found: dict[str, CostToGo | None] = {}

    def aim(self, place: str, goal: Points) -> None:
        """Lets the paths to a place end at another point."""
        self._goals[place] = goal
        self._found.pop(place, None)
        self._outdated.pop(place, None)

    def find(self, max_cells: int) -> bool:
        """Searches about `max_cells` cells for what is not known yet; True once all is known."""
        for place in self._goals:
            if place not in self._found:
                if max_cells <= 0:
                    return False
                found = self.cost_to_go(place)
                max_cells -= max(found.searched, _REPAIR_OVERHEAD) if found else 0
        return True

    def cost_to_go(self, place: str) -> CostToGo | None:
        """The cost-to-go of a place; None if the place cannot be reached from its own cell.

        Raises:
            KeyError: there is no such place.
        """
        if place not in self._found:
            self._found[place] = self._search(place)
        return self._found[place]

    def _search(self, place: str) -> CostToGo | None:
        goal = self._goals[place]
        row, col = np.floor(goal).astype(int).tolist()
        rows, cols = self._free.shape
        if not (0 <= row < rows and 0 <= col < cols and self._free[row, col]):
            return None
        centre = np.array((row + 0.5, col + 0.5))
        if self._regions.without(place).are_entered(centre, goal):
            return None
        graph = self._allowed(place)
        previous = self._outdated.get(place)
        found = repaired(previous, graph) if previous else cost_to_go(graph, (row, col))
        self._outdated[place] = found
        return found

    def _allowed(self, place: str) -> GridGraph:
        """The edges that a path to a place may use."""
        self._graph = self._graph or grid_graph(self._free)
        if place not in self._barred:
            others = (edges for name, edges in self._entering.items() if name != place)
            self._barred[place] = union(others, self._free.shape)
        return self._graph.without(self._barred[place])
