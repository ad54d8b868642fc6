"""Cost-to-go on the grid graph: each cell's distance to a goal, and the next cell on the path.

Dijkstra searches from the goal, against the direction of the edges (scipy.sparse.csgraph), find it,
some tiles of the map at a time, as in the heap-cell method (Chacon and Vladimirsky, Fast two-scale
methods for Eikonal equations, SIAM J. Sci. Comput. 34, 2012):

1. A search finds the shortest paths from the cells of some tiles to the cells around them, whose
   costs are those of real paths. If an edge would then shorten the path of a cell around them, the
   tile of that cell has to be searched, with the least cost that such a path would have.
2. The tiles with the least such cost are searched first. So nearly all cells are searched only
   once.
3. In the end no edge shortens a path, and each cost is that of a real path. So the paths are
   shortest, in whatever order tiles were searched.

After a change of the map only those cells are searched again whose path changes: paths over an edge
that is gone are lost, and new edges may shorten paths.

Graphs, cells and flat indices are those of `grid_graph.py`.
"""

from __future__ import annotations

import math
import sys
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy import ndimage, sparse
from scipy.sparse import csgraph

from companion.motion.grid_graph import OFFSETS, Cell, Cells, GridGraph, Lengths, edge_lengths

ALL = sys.maxsize
"""More cells than any map has."""
NextCells = npt.NDArray[np.int32]
"""Flat indices in half the memory; maps have fewer cells than 2^31."""
_ROUNDING = 1e-9  # cells; paths count as equally long if they differ by less
_TILE = 20  # cells along each side


@dataclass(frozen=True, slots=True, eq=False)
class CostToGo:
    """The shortest paths from all cells to one goal.

    Attributes:
        graph: the edges that a path may use.
        cost: (rows, cols) length of the path in cells, inf if there is none.
        next_cell: (rows * cols,) flat index of the next cell on a shortest path; the cell's own
            index at the goal and if there is no path.
        searched: number of cells that have been searched for it so far.
        due: (tile rows, tile cols) the cost above which cells of a tile still have to be searched,
            inf if none has to be.
        horizon: the least of these. All costs are those of real paths; up to the horizon, those of
            shortest paths.
    """

    graph: GridGraph
    cost: Lengths
    next_cell: NextCells
    searched: int
    due: Lengths
    horizon: float

    def is_final(self, cell: Cell | None = None) -> bool:
        """Whether the cost of a cell, or of all cells, is that of a shortest path."""
        return self.horizon >= (self.cost[cell] if cell else math.inf)

    def path(self, start: Cell) -> npt.NDArray[np.int_]:
        """(n, 2) cells on the path from a cell that has one, up to the goal.

        Among equally short paths it is the one with the first edges, whatever the map was before.
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
    return continued(begun(graph, goal), ALL)


def repaired(previous: CostToGo, graph: GridGraph) -> CostToGo:
    """The shortest paths to the same goal on another graph; the goal is free on both maps."""
    return continued(adapted(previous, graph), ALL)


def begun(graph: GridGraph, goal: Cell) -> CostToGo:
    """The cost-to-go of a free cell, before any search."""
    cost = np.full(graph.outgoing.shape, np.inf)
    cost[goal] = 0.0
    draft = _Draft(graph, cost, np.arange(cost.size, dtype=np.int32), _nothing_due(cost.shape))
    draft.look_from(np.array([np.ravel_multi_index(goal, cost.shape)]))
    return draft.result(searched=0)


def adapted(previous: CostToGo, graph: GridGraph) -> CostToGo:
    """The cost-to-go of the same goal on another graph, before it is searched there.

    Args:
        previous: may be unfinished.
        graph: a graph on which the goal is still free.
    """
    gone = previous.graph.outgoing & ~graph.outgoing
    new = graph.outgoing & ~previous.graph.outgoing
    has_lost = _has_lost(previous.next_cell, GridGraph(gone, gone)).reshape(gone.shape)
    draft = _Draft(graph, previous.cost.copy(), previous.next_cell.copy(), previous.due.copy())
    draft.forget(_flat(has_lost))
    draft.look_at(_flat(_rim(has_lost) | (new != 0)))
    return draft.result(searched=0)


def continued(to_go: CostToGo, max_cells: int, cell: Cell | None = None) -> CostToGo:
    """The cost-to-go after searching about `max_cells` more cells.

    Args:
        to_go: the cost-to-go so far.
        max_cells: see above.
        cell: the cell whose cost has to become final; None for all cells.
    """
    if to_go.is_final(cell):
        return to_go
    draft = _Draft(to_go.graph, to_go.cost.copy(), to_go.next_cell.copy(), to_go.due.copy())
    searched = 0
    while searched < max_cells and not draft.result(searched).is_final(cell):
        cells = draft.due_cells(max_cells - searched)
        draft.search(cells)
        searched += len(cells)
    return draft.result(to_go.searched + searched)


def _has_lost(next_cell: NextCells, gone: GridGraph) -> npt.NDArray[np.bool_]:
    """(rows * cols,) whether the path from each cell uses an edge that is gone.

    By pointer jumping: at first those cells count whose own edge is gone; then, in each pass, those
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


def _rim(mask: npt.NDArray[np.bool_]) -> npt.NDArray[np.bool_]:
    """The cells of a mask (rows, cols) from which an edge may lead out of it."""
    reach = 2 * int(np.abs(OFFSETS).max()) + 1
    return np.asarray(mask & ~ndimage.minimum_filter(mask, size=reach, mode="constant", cval=True))


class _Draft:
    """A cost-to-go during a search.

    Args:
        graph: the edges that a path may use.
        cost: (rows, cols) 0 at the goal; elsewhere the length of some real path, or inf. Modified.
        next_cell: (rows * cols,) the next cell on that path. Modified.
        due: (tile rows, tile cols) see `CostToGo`. Modified.
    """

    def __init__(self, graph: GridGraph, cost: Lengths, next_cell: NextCells, due: Lengths) -> None:
        self._graph = graph
        self._shape = cost.shape
        self._cost = cost.reshape(-1)
        self._next_cell = next_cell
        self._due = due

    def result(self, searched: int) -> CostToGo:
        """The cost-to-go as it is now."""
        cost = self._cost.reshape(self._shape)
        horizon = float(self._due.min())
        return CostToGo(self._graph, cost, self._next_cell, searched, self._due, horizon)

    def due_cells(self, max_cells: int) -> Cells:
        """About `max_cells` cells to search next: those of the tiles with the least costs."""
        due = self._due.reshape(-1)
        first = np.argsort(due, kind="stable")[: max(1, max_cells // _TILE**2)]
        above = np.full(self._due.shape, np.inf)
        above.reshape(-1)[first] = due[first]
        due[first] = np.inf
        rows, cols = self._shape
        each = above.repeat(_TILE, axis=0)[:rows].repeat(_TILE, axis=1)[:, :cols]
        is_due = self._cost.reshape(self._shape) > each
        return _flat(is_due & (self._graph.outgoing != 0))

    def forget(self, cells: Cells) -> None:
        """Removes the paths of some cells."""
        self._cost[cells] = np.inf
        self._next_cell[cells] = cells

    def look_at(self, cells: Cells) -> None:
        """Notes which of some cells get a shorter path by an edge."""
        near, costs = self._graph.successors(cells)
        costs = np.min(costs + self._cost.take(near, mode="clip"), axis=1)
        is_shorter = costs < self._cost[cells] - _ROUNDING
        self._note(cells[is_shorter], costs[is_shorter])

    def look_from(self, cells: Cells) -> None:
        """Notes the cells that get a shorter path by an edge to one of some cells."""
        origins, costs = self._graph.predecessors(cells)
        costs += self._cost[cells][:, None]
        is_shorter = costs < self._cost.take(origins, mode="clip") - _ROUNDING
        self._note(origins[is_shorter], costs[is_shorter])

    def search(self, cells: Cells) -> None:
        """Finds the shortest paths from some cells (n,), to those around them and on from there."""
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
        self.look_from(rim)

    def _note(self, cells: Cells, costs: Lengths) -> None:
        """Notes that cells above these costs are due in the tiles of some cells (k,)."""
        rows, cols = np.divmod(cells, self._shape[1])
        np.minimum.at(self._due, (rows // _TILE, cols // _TILE), costs)


def _nothing_due(shape: tuple[int, ...]) -> Lengths:
    """(tile rows, tile cols) of inf, for a map."""
    return np.full([-(-edge // _TILE) for edge in shape], np.inf)


class _Subgraph:
    """The edges among some cells, and from them to the cells around them.

    Args:
        graph: the edges of the whole map.
        cells: (n,) numbered here from 0 to n - 1; all other cells have the number n.

    Attributes:
        rim: (m,) numbers of the cells from which an edge may lead to another cell.
    """

    def __init__(self, graph: GridGraph, cells: Cells) -> None:
        self._count = count = len(cells)
        number = np.full(graph.incoming.size, count, dtype=np.int32)
        number[cells] = np.arange(count, dtype=np.int32)
        # Rows of 16, with space for one more row.
        steps = graph.index_steps
        rows = (count, len(steps))
        size = count * len(steps)
        self._ends, self._lengths = np.empty(size + count, np.int32), np.empty(size + count)
        edge_lengths(graph.incoming.ravel()[cells], out=self._lengths[:size].reshape(rows))
        columns = np.empty(rows[::-1], np.int32)  # looking up each at once is quicker
        for column, step in zip(columns, steps, strict=True):
            number.take(cells + step, mode="clip", out=column)
        self._ends[:size].reshape(rows)[:] = columns.T
        (self.rim,) = np.nonzero(np.any(columns == count, axis=0))

    def shortest(self, exits: Lengths) -> tuple[Lengths, npt.NDArray[np.int32]]:
        """Runs a Dijkstra search from around the cells.

        Args:
            exits: (m,) for each cell of the rim, the length of a path that leaves the subgraph
                there at once; inf if it has none.

        Returns:
            (n,) lengths of the shortest paths, inf if there is none.
            (n,) the next cells on them; n + 1: the path leaves the subgraph here; negative: there
            is no path.
        """
        count, has_exit = self._count, np.isfinite(exits)
        if not has_exit.any():
            return np.full(count, np.inf), np.full(count, -1, dtype=np.int32)
        # The last two rows: the surroundings, from which no edge leads; the start, joined to the
        # rim.
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
