"""Fields of the way to a goal: from each free cell, how far is it and which cell comes next?

A Dijkstra search from the goal over the moves backwards gives a field (scipy.sparse.csgraph). When
the map has changed, only those cells are searched again whose way changes:

1. The cells whose way uses a move that is gone lose it. They, and those that new moves lead away
   from, are searched from the cells around them, whose costs are those of real ways.
2. Where a move would then make the way of a cell around them shorter, the region beyond is
   searched too, and so on. In the end no move makes a way shorter, and each cost is that of a real
   way: so costs are those of a new field, whichever regions were searched.

Moves, cells and flat indices are those of `moves.py`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy import sparse
from scipy.sparse import csgraph

from companion.motion.moves import Cell, Cells, Lengths, Moves, lengths_of

_ROUNDING = 1e-9  # cells; ways that differ by less are equally long
_MARGIN, _WIDER = 8, 2  # cells around a region that is searched next, and by how much it grows


@dataclass(frozen=True, slots=True, eq=False)
class Field:
    """The way to one goal.

    Attributes:
        moves: that a way may use.
        cost: (rows, cols) length of the way in cells, inf where there is none.
        onward: (rows * cols,) flat index of the next cell on a shortest way; the cell's own where
            the way ends or there is none.
        searched: how many cells have been searched to make or repair it.
    """

    moves: Moves
    cost: Lengths
    onward: Cells
    searched: int

    def path(self, start: Cell) -> npt.NDArray[np.int_]:
        """(n, 2) cells on the way from a cell that has one, up to the goal.

        Of equally short ways it is the one with the first moves, whatever the map was before.
        """
        cost, away, steps = self.cost.ravel(), self.moves.away.ravel(), self.moves.steps
        here = start[0] * self.cost.shape[1] + start[1]
        way = [here]
        while cost[here] > 0:
            near = here + steps
            ways = cost.take(near, mode="clip") + lengths_of(away[here])
            here = int(near[(ways <= ways.min() + _ROUNDING).argmax()])
            way.append(here)
        return np.stack(np.divmod(np.array(way), self.cost.shape[1]), axis=1)


def searched(moves: Moves, goal: Cell) -> Field:
    """The way to a free cell from everywhere."""
    cost = np.full(moves.away.shape, np.inf)
    cost[goal] = 0.0
    draft = _Draft(moves, cost, np.arange(cost.size))
    draft.search(_flat((moves.away != 0) & (cost > 0)))
    return draft.field()


def repaired(field: Field, moves: Moves) -> Field:
    """The way to the same goal by other moves; the goal is free on both maps."""
    gone, new = field.moves.away & ~moves.away, moves.away & ~field.moves.away
    has_lost = _has_lost(field.onward, Moves(gone, gone)).reshape(gone.shape)
    draft = _Draft(moves, np.where(has_lost, np.inf, field.cost), field.onward.copy())
    cells, margin = _flat((has_lost | (new != 0)) & (field.cost > 0)), _MARGIN
    while cells.size:
        cells = draft.beyond(*draft.search(cells), margin)
        margin *= _WIDER
    return draft.field()


def _has_lost(onward: Cells, gone: Moves) -> npt.NDArray[np.bool_]:
    """(rows * cols,) whether the way from each cell uses a move that is gone.

    First of the cells that make the move themselves; then, in each round, of those whose way comes
    through one of these within twice as many moves as in the round before.
    """
    at = _flat(gone.away)
    near, lengths = gone.leading_away(at)
    lost = np.zeros(len(onward), dtype=np.bool_)
    lost[at] = np.any((near == onward[at][:, None]) & np.isfinite(lengths), axis=1)
    before = 0
    while (count := int(np.count_nonzero(lost))) > before:
        before = count
        lost |= lost[onward]
        onward = onward[onward]
    return lost


class _Draft:
    """A field in the making.

    Args:
        moves: that a way may use.
        cost: (rows, cols) 0 at the goal; elsewhere the length of some real way, or inf. Changed.
        onward: (rows * cols,) the next cell on that way. Changed.
    """

    def __init__(self, moves: Moves, cost: Lengths, onward: Cells) -> None:
        self._moves = moves
        self._shape = cost.shape
        self._cost = cost.reshape(-1)
        self._onward = onward
        self._searched = 0

    def field(self) -> Field:
        """What has been found."""
        return Field(self._moves, self._cost.reshape(self._shape), self._onward, self._searched)

    def search(self, cells: Cells) -> tuple[Cells, Lengths]:
        """Finds the shortest ways from some cells (n,) to those around them, and on from there.

        Returns:
            (k,) cells around them that would have a shorter way by a move to one of them.
            (k,) how long it would be.
        """
        self._searched += len(cells)
        graph = _Graph(self._moves, cells)
        rim = cells[graph.rim]
        near, entries = self._moves.leading_away(rim)
        entries += self._cost.take(near, mode="clip")
        best = np.arange(len(rim)), np.argmin(entries, axis=1)
        cost, onward = graph.shortest(entries[best])
        self._cost[cells] = cost
        self._onward[cells] = np.where(onward >= 0, cells.take(onward, mode="clip"), cells)
        is_entry = onward[graph.rim] > len(cells)
        self._onward[rim[is_entry]] = near[best][is_entry]

        origins, lengths = self._moves.leading_onto(rim)
        ways = cost[graph.rim][:, None] + lengths
        is_shorter = ways < self._cost.take(origins, mode="clip") - _ROUNDING
        is_shorter &= graph.is_outside(origins)
        return origins[is_shorter], ways[is_shorter]

    def beyond(self, cells: Cells, ways: Lengths, margin: int) -> Cells:
        """What to search next: where ways may be shorter, in a rectangle and a margin.

        Args:
            cells: (k,) whose way is shorter.
            ways: (k,) how long they are.
            margin: in cells.
        """
        if not cells.size:
            return cells
        row, col = np.divmod(cells, self._shape[1])
        south, west = np.maximum((row.min() - margin, col.min() - margin), 0)
        window = np.s_[south : row.max() + margin + 1, west : col.max() + margin + 1]
        is_next = np.zeros(self._shape, dtype=np.bool_)
        is_next[window] = self._cost.reshape(self._shape)[window] > ways.min()
        return _flat(is_next & (self._moves.away != 0))


class _Graph:
    """The moves among some cells, and from them to what is around.

    Args:
        moves: on the map.
        cells: (n,) here they are numbered from 0 to n - 1; all others have the number n.

    Attributes:
        rim: (m,) numbers of those from which a move may lead to another cell.
    """

    def __init__(self, moves: Moves, cells: Cells) -> None:
        self._count = count = len(cells)
        self._number = np.full(moves.onto.size, count, dtype=np.int32)
        self._number[cells] = np.arange(count, dtype=np.int32)
        # Rows of 16, and space for one more row. Column by column, since large arrays in between
        # would cost more than all the rest.
        rows = (count, len(moves.steps))
        size = count * len(moves.steps)
        self._ends, self._lengths = np.empty(size + count, np.int32), np.empty(size + count)
        lengths_of(moves.onto.ravel()[cells], out=self._lengths[:size].reshape(rows))
        ends, is_rim = self._ends[:size].reshape(rows), np.zeros(count, dtype=np.bool_)
        for column, step in zip(ends.T, moves.steps, strict=True):
            column[:] = self._number.take(cells + step, mode="clip")
            is_rim |= column == count
        (self.rim,) = np.nonzero(is_rim)

    def is_outside(self, cells: Cells) -> npt.NDArray[np.bool_]:
        """Whether cells (...) are none of those of the graph."""
        return np.asarray(self._number.take(cells, mode="clip") == self._count)

    def shortest(self, entries: Lengths) -> tuple[Lengths, npt.NDArray[np.int32]]:
        """A Dijkstra search from around the cells.

        Args:
            entries: (m,) of each cell of the rim, the length of a way of its own, inf if it has
                none.

        Returns:
            (n,) lengths of the ways, inf where there is none.
            (n,) the cells next on the ways; n + 1: the way of its own; negative: there is no way.
        """
        count, enter = self._count, np.isfinite(entries)
        if not enter.any():
            return np.full(count, np.inf), np.full(count, -1, dtype=np.int32)
        # The last two rows: what is around, where no move goes on; the start, joined to the rim.
        first = np.arange(0, len(self._ends) - count + 1, len(self._ends) // count - 1)
        end = first[-1] + np.count_nonzero(enter)
        self._ends[first[-1] : end] = self.rim[enter]
        self._lengths[first[-1] : end] = entries[enter]
        rows = np.concatenate((first, (first[-1], end))).astype(np.int32)
        cost, onward = csgraph.dijkstra(
            sparse.csr_array(
                (self._lengths[:end], self._ends[:end], rows), shape=(count + 2, count + 2)
            ),
            indices=np.array(count + 1),
            return_predecessors=True,
            limit=np.finfo(np.float64).max,  # a move of infinite length leads nowhere
        )
        return cost[:count], onward[:count]


def _flat(mask: npt.NDArray[np.generic]) -> Cells:
    """Flat indices of the cells where a mask (rows, cols) is not zero."""
    return np.flatnonzero(mask)
