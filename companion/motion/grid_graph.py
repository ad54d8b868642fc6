"""The grid graph: free cells joined by 16 kinds of edges.

An edge leads from a cell to one of its 8 neighbours or, as a knight moves in chess, to one of 8
more. So a path along edges is at most 2.75 % longer than a straight one (1 / cos of half the angle
between two edges). An edge exists if every cell that it crosses or touches is free, and then in
both directions. Edges may be removed in one direction, such as those that enter a region.

The edges at a cell are the bits of one number: bit i stands for the cell at `OFFSETS[i]` from it.
So one operation for each cell removes edges, or compares two maps.

Cells are (row, column); a flat index is row * cols + col. Points are in cells
(`line_of_sight.py`).
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cache

import numpy as np
import numpy.typing as npt

from companion.motion.regions import Regions

Cell = tuple[int, int]
Cells = npt.NDArray[np.intp]
"""Flat indices."""
EdgeBits = npt.NDArray[np.uint16]
"""(rows, cols) the edges at each cell, as bits."""
Lengths = npt.NDArray[np.float64]

_QUADRANTS = ((1, 1), (1, -1), (-1, 1), (-1, -1))
_CROSSED: dict[Cell, tuple[Cell, ...]] = {  # offset: the cells between that the edge touches
    **{offset: () for offset in ((1, 0), (-1, 0), (0, 1), (0, -1))},
    **{(r, c): ((r, 0), (0, c)) for r, c in _QUADRANTS},
    **{(r, 2 * c): ((0, c), (r, c)) for r, c in _QUADRANTS},
    **{(2 * r, c): ((r, 0), (r, c)) for r, c in _QUADRANTS},
}
OFFSETS = np.array(list(_CROSSED))
_REVERSED = np.array([list(_CROSSED).index((-row, -col)) for row, col in _CROSSED])
_REACH = 2  # cells; the longest component of an edge
_FLAGS = (1 << np.arange(len(_CROSSED))).astype(np.uint16)


@dataclass(frozen=True, slots=True, eq=False)
class GridGraph:
    """The edges between the cells of a map, stored at both of their ends.

    Attributes:
        outgoing: edges from each cell to the cell at the offset.
        incoming: edges to each cell from the cell at the offset.
    """

    outgoing: EdgeBits
    incoming: EdgeBits

    def successors(self, cells: Cells) -> tuple[Cells, Lengths]:
        """Where the edges from some cells (n,) lead, and how long they are.

        Returns:
            (n, 16) cells, which may lie off the map if there is no such edge.
            (n, 16) lengths in cells, inf if there is no such edge.
        """
        return cells[:, None] + self.index_steps, edge_lengths(self.outgoing.ravel()[cells])

    def predecessors(self, cells: Cells) -> tuple[Cells, Lengths]:
        """Where the edges to some cells (n,) begin, and their lengths; shaped as `successors`."""
        return cells[:, None] + self.index_steps, edge_lengths(self.incoming.ravel()[cells])

    @property
    def index_steps(self) -> Cells:
        """(16,) what each edge from a cell adds to the cell's flat index."""
        return np.asarray(OFFSETS @ (self.outgoing.shape[1], 1))

    def without(self, others: GridGraph) -> GridGraph:
        """The graph without the edges of another one."""
        return GridGraph(self.outgoing & ~others.outgoing, self.incoming & ~others.incoming)


def grid_graph(free: npt.NDArray[np.bool_]) -> GridGraph:
    """The graph of all edges between free cells.

    Args:
        free: (rows, cols); cells off the map are not free.

    >>> graph = grid_graph(np.array([[True, True], [True, False]]))
    >>> [int(edges).bit_count() for edges in graph.outgoing.ravel()]  # no diagonal past a corner
    [2, 1, 1, 0]
    """
    rows, cols = free.shape
    framed = np.pad(free, _REACH)

    def is_free(row: int, col: int) -> npt.NDArray[np.bool_]:
        """Whether the cell at an offset from each cell is free."""
        return framed[_REACH + row :, _REACH + col :][:rows, :cols]

    bits = np.zeros(free.shape, dtype=np.uint16)
    for flag, (offset, crossed) in zip(_FLAGS, _CROSSED.items(), strict=True):
        exists = free & is_free(*offset)
        for cell in crossed:
            exists &= is_free(*cell)
        bits |= exists * flag
    return GridGraph(bits, bits)


def edges_entering(shape: Cell, regions: Regions) -> GridGraph:
    """The edges that enter a region from outside, whether or not their cells are free.

    Args:
        shape: rows and columns of the map.
        regions: the cells of each region.
    """
    near = regions.border(shape, _REACH)
    origin = near[:, None] + OFFSETS
    ends = np.asarray(near[:, None] + 0.5, dtype=np.float64)
    enter = regions.are_entered(origin + 0.5, ends)
    cell, i = np.nonzero(enter & np.all((origin >= 0) & (origin < shape), axis=-1))
    edges = empty_graph(shape)
    np.bitwise_or.at(edges.incoming, tuple(near[cell].T), _FLAGS[i])
    np.bitwise_or.at(edges.outgoing, tuple(origin[cell, i].T), _FLAGS[_REVERSED[i]])
    return edges


def empty_graph(shape: Cell) -> GridGraph:
    """The graph of a map without any edges."""
    return GridGraph(np.zeros(shape, dtype=np.uint16), np.zeros(shape, dtype=np.uint16))


def union(graphs: Iterable[GridGraph], shape: Cell) -> GridGraph:
    """The edges of several graphs of the same map."""
    found = empty_graph(shape)
    for graph in graphs:
        np.bitwise_or(found.outgoing, graph.outgoing, out=found.outgoing)
        np.bitwise_or(found.incoming, graph.incoming, out=found.incoming)
    return found


def overlap(graphs: Iterable[GridGraph], shape: Cell) -> GridGraph:
    """The edges that at least two of several graphs of the same map have."""
    seen, found = empty_graph(shape), empty_graph(shape)
    for graph in graphs:
        found = union((found, seen.without(seen.without(graph))), shape)
        seen = union((seen, graph), shape)
    return found


def edge_lengths(bits: EdgeBits, out: Lengths | None = None) -> Lengths:
    """(n, 16) lengths of the edges at some cells (n,), inf if there is no edge."""
    return _length_table().take(bits, axis=0, out=out, mode="clip")


@cache
def _length_table() -> Lengths:
    """(65536, 16) the lengths for each number.

    The numbers are wide, 8 MB in between: the C library then keeps that much memory when a search
    frees it, which makes large searches a third quicker.
    """
    numbers, flags = np.arange(1 << len(_CROSSED)), 1 << np.arange(len(_CROSSED))
    return np.where(numbers[:, None] & flags, np.hypot(*OFFSETS.T), np.inf)
