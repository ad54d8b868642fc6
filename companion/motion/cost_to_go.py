"""Cost-to-go on the grid graph: each cell's distance to a goal, and the next cell on the path.

A Dijkstra search from the goal against the direction of the edges finds it (scipy.sparse.csgraph).
When the map has changed, only those cells are searched again whose path changes:

1. The cells whose path uses an edge that is gone lose it. They, and those that new edges leave,
   are searched from the cells around them, whose costs are those of real paths.
2. Where an edge would then shorten the path of a cell around them, the region beyond is searched
   too, and so on. In the end no edge shortens a path, and each cost is that of a real path: so
   the costs are those of a new search, whichever regions were searched.

Graphs, cells and flat indices are those of `grid_graph.py`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy import sparse
from scipy.sparse import csgraph

from companion.motion.grid_graph import Cell, Cells, GridGraph, Lengths, edge_lengths

_ROUNDING = 1e-9  # cells; paths that differ by less are equally long
_MARGIN = 8  # cells around a region that is searched next
_MARGIN_GROWTH = 2  # factor from one search to the next


@dataclass(frozen=True, slots=True, eq=False)
class CostToGo:
    """The shortest paths from all cells to one goal.

    Attributes:
        graph: the edges that a path may use.
        cost: (rows, cols) length of the path in cells, inf where there is none.
        next_cell: (rows * cols,) flat index of the next cell on a shortest path; the cell's own at
            the goal and where there is no path.
        searched: number of cells that were searched to make or repair it.
    """

    graph: GridGraph
    cost: Lengths
    next_cell: Cells
    searched: int

    def path(self, start: Cell) -> npt.NDArray[np.int_]:
        """(n, 2) cells on the path from a cell that has one, up to the goal.

        Of equally short paths it is the one with the first edges, whatever the map was before.
        """
        cost, outgoing = self.cost.ravel(), self.graph.outgoing.ravel()
        steps = self.graph.index_steps
        here = start[0] * self.cost.shape[1] + start[1]
        path = [here]
        while cost[here] > 0:
            near = here + steps
            costs = cost.take(near, mode="clip") + edge_lengths(outgoing[here])
            here = int(near[(costs <= costs.min() + _ROUNDING).argmax()])
            path.append(here)
        return np.stack(np.divmod(np.array(path), self.cost.shape[1]), axis=1)


def cost_to_go(graph: GridGraph, goal: Cell) -> CostToGo:
    """The shortest paths from everywhere to a free cell.

    >>> from companion.motion.grid_graph import grid_graph
    >>> floor = grid_graph(np.ones((2, 4), dtype=np.bool_))
    >>> cost_to_go(floor, (0, 0)).path((1, 3)).tolist()
    [[1, 3], [1, 2], [0, 0]]
    """
    cost = np.full(graph.outgoing.shape, np.inf)
    cost[goal] = 0.0
    draft = _Draft(graph, cost, np.arange(cost.size))
    draft.search(_flat((graph.outgoing != 0) & (cost > 0)))
    return draft.finished()


def repaired(previous: CostToGo, graph: GridGraph) -> CostToGo:
    """The shortest paths to the same goal on another graph; the goal is free on both maps."""
    gone = previous.graph.outgoing & ~graph.outgoing
    new = graph.outgoing & ~previous.graph.outgoing
    has_lost = _has_lost(previous.next_cell, GridGraph(gone, gone)).reshape(gone.shape)
    costs = np.where(has_lost, np.inf, previous.cost)
    draft = _Draft(graph, costs, previous.next_cell.copy())
    cells, margin = _flat((has_lost | (new != 0)) & (previous.cost > 0)), _MARGIN
    while cells.size:
        cells = draft.beyond(*draft.search(cells), margin)
        margin *= _MARGIN_GROWTH
    return draft.finished()


def _has_lost(next_cell: Cells, gone: GridGraph) -> npt.NDArray[np.bool_]:
    """(rows * cols,) whether the path from each cell uses an edge that is gone.

    Pointer jumping: first those cells count whose own edge is gone; then, in each pass, those
    whose path leads to one of these within twice as many edges as in the pass before.
    """
    at = _flat(gone.outgoing)
    near, lengths = gone.successors(at)
    lost = np.zeros(len(next_cell), dtype=np.bool_)
    lost[at] = np.any((near == next_cell[at][:, None]) & np.isfinite(lengths), axis=1)
    before = 0
    while (count := int(np.count_nonzero(lost))) > before:
        before = count
        lost |= lost[next_cell]
        next_cell = next_cell[next_cell]
    return lost


class _Draft:
    """A cost-to-go that is not finished.

    Args:
        graph: the edges that a path may use.
        cost: (rows, cols) 0 at the goal; elsewhere the length of some real path, or inf. Changed.
        next_cell: (rows * cols,) the next cell on that path. Changed.
    """

    def __init__(self, graph: GridGraph, cost: Lengths, next_cell: Cells) -> None:
        self._graph = graph
        self._shape = cost.shape
        self._cost = cost.reshape(-1)
        self._next_cell = next_cell
        self._searched = 0

    def finished(self) -> CostToGo:
        """The result of the searches."""
        cost = self._cost.reshape(self._shape)
        return CostToGo(self._graph, cost, self._next_cell, self._searched)

    def search(self, cells: Cells) -> tuple[Cells, Lengths]:
        """Finds the shortest paths from some cells (n,) to those around them, and on from there.

        Returns:
            (k,) cells around them that would have a shorter path by an edge to one of them.
            (k,) its length.
        """
        self._searched += len(cells)
        subgraph = _Subgraph(self._graph, cells)
        rim = cells[subgraph.rim]
        near, exits = self._graph.successors(rim)
        exits += self._cost.take(near, mode="clip")
        best = np.arange(len(rim)), np.argmin(exits, axis=1)
        cost, following = subgraph.shortest(exits[best])
        self._cost[cells] = cost
        self._next_cell[cells] = np.where(following >= 0, cells.take(following, mode="clip"), cells)
        is_exit = following[subgraph.rim] > len(cells)
        self._next_cell[rim[is_exit]] = near[best][is_exit]

        origins, lengths = self._graph.predecessors(rim)
        costs = cost[subgraph.rim][:, None] + lengths
        is_shorter = costs < self._cost.take(origins, mode="clip") - _ROUNDING
        is_shorter &= subgraph.is_outside(origins)
        return origins[is_shorter], costs[is_shorter]

    def beyond(self, cells: Cells, costs: Lengths, margin: int) -> Cells:
        """The cells to search next: where paths may be shorter, in a rectangle and a margin.

        Args:
            cells: (k,) whose path is shorter.
            costs: (k,) its length.
            margin: in cells.
        """
        if not cells.size:
            return cells
        row, col = np.divmod(cells, self._shape[1])
        south, west = np.maximum((row.min() - margin, col.min() - margin), 0)
        window = np.s_[south : row.max() + margin + 1, west : col.max() + margin + 1]
        is_next = np.zeros(self._shape, dtype=np.bool_)
        is_next[window] = self._cost.reshape(self._shape)[window] > costs.min()
        return _flat(is_next & (self._graph.outgoing != 0))


class _Subgraph:
    """The edges among some cells, and from them to the cells around them.

    Args:
        graph: of the whole map.
        cells: (n,) here they are numbered from 0 to n - 1; all others have the number n.

    Attributes:
        rim: (m,) numbers of those from which an edge may lead to another cell.
    """

    def __init__(self, graph: GridGraph, cells: Cells) -> None:
        self._count = count = len(cells)
        self._number = np.full(graph.incoming.size, count, dtype=np.int32)
        self._number[cells] = np.arange(count, dtype=np.int32)
        # Rows of 16, and space for one more row. Column by column, since large arrays in between
        # would cost more than all the rest.
        steps = graph.index_steps
        rows = (count, len(steps))
        size = count * len(steps)
        self._ends, self._lengths = np.empty(size + count, np.int32), np.empty(size + count)
        edge_lengths(graph.incoming.ravel()[cells], out=self._lengths[:size].reshape(rows))
        ends, is_rim = self._ends[:size].reshape(rows), np.zeros(count, dtype=np.bool_)
        for column, step in zip(ends.T, steps, strict=True):
            column[:] = self._number.take(cells + step, mode="clip")
            is_rim |= column == count
        (self.rim,) = np.nonzero(is_rim)

    def is_outside(self, cells: Cells) -> npt.NDArray[np.bool_]:
        """Whether cells (...) are none of those of the subgraph."""
        return np.asarray(self._number.take(cells, mode="clip") == self._count)

    def shortest(self, exits: Lengths) -> tuple[Lengths, npt.NDArray[np.int32]]:
        """A Dijkstra search from around the cells.

        Args:
            exits: (m,) for each cell of the rim the length of a path that leaves the subgraph there
                at once, inf if it has none.

        Returns:
            (n,) lengths of the shortest paths, inf where there is none.
            (n,) the next cells on them; n + 1: the path leaves here; negative: there is no path.
        """
        count, has_exit = self._count, np.isfinite(exits)
        if not has_exit.any():
            return np.full(count, np.inf), np.full(count, -1, dtype=np.int32)
        # The last two rows: what is around, where no edge goes on; the start, joined to the rim.
        first = np.arange(0, len(self._ends) - count + 1, len(self._ends) // count - 1)
        end = first[-1] + np.count_nonzero(has_exit)
        self._ends[first[-1] : end] = self.rim[has_exit]
        self._lengths[first[-1] : end] = exits[has_exit]
        rows = np.concatenate((first, (first[-1], end))).astype(np.int32)
        cost, following = csgraph.dijkstra(
            sparse.csr_array(
                (self._lengths[:end], self._ends[:end], rows), shape=(count + 2, count + 2)
            ),
            indices=np.array(count + 1),
            return_predecessors=True,
            limit=np.finfo(np.float64).max,  # an edge of infinite length leads nowhere
        )
        return cost[:count], following[:count]


def _flat(mask: npt.NDArray[np.generic]) -> Cells:
    """Flat indices of the cells where a mask (rows, cols) is not zero."""
    return np.flatnonzero(mask)
