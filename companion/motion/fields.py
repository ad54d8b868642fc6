"""Fields of the way to a goal: from each free cell, how far is it and which cell comes next?

Free cells form a graph with 16 moves from each: 8 neighbours and the knight's moves, so that a
path along moves is at most 2.75 % longer than a straight one (1 / cos of half the angle between
two moves). A move exists if every cell that it crosses or touches is free. One Dijkstra search
from the goal over the reversed moves gives the field (scipy.sparse.csgraph); moves can be taken
out of it by their direction, e.g. those that come into a region.

Cells are (row, column); a flat index is row * cols + col. Points are in cells (`sight.py`).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy import sparse
from scipy.sparse import csgraph

from companion.motion.sight import enters

Cell = tuple[int, int]

_QUADRANTS = ((1, 1), (1, -1), (-1, 1), (-1, -1))
_MOVES: dict[Cell, tuple[Cell, ...]] = {  # move: the cells between that it crosses or touches
    **{move: () for move in ((1, 0), (-1, 0), (0, 1), (0, -1))},
    **{(r, c): ((r, 0), (0, c)) for r, c in _QUADRANTS},
    **{(r, 2 * c): ((0, c), (r, c)) for r, c in _QUADRANTS},
    **{(2 * r, c): ((r, 0), (r, c)) for r, c in _QUADRANTS},
}
_OFFSETS = np.array(list(_MOVES))
_LENGTHS = np.hypot(*_OFFSETS.T)
_REACH = 2  # the longest component of a move


@dataclass(frozen=True, slots=True, eq=False)
class Field:
    """The way to one goal.

    Attributes:
        cost: (rows, cols) length of the way in cells, inf where there is none.
        onward: (rows * cols,) flat index of the next cell on the way, negative where it ends.
    """

    cost: npt.NDArray[np.float64]
    onward: npt.NDArray[np.int32]

    def path(self, start: Cell) -> npt.NDArray[np.int_]:
        """(n, 2) cells on the way from a cell that has one, up to the goal."""
        cols = self.cost.shape[1]
        flat = start[0] * cols + start[1]
        cells = []
        while flat >= 0:
            cells.append(divmod(flat, cols))
            flat = int(self.onward[flat])
        return np.array(cells)


class MoveGraph:
    """The moves between free cells, numbered by the cell where they arrive.

    Args:
        free: (rows, cols) bool; everything outside is not free.
    """

    def __init__(self, free: npt.NDArray[np.bool_]) -> None:
        self._shape = rows, cols = free.shape
        framed = np.pad(free, _REACH)

        def is_free(row: int, col: int) -> npt.NDArray[np.bool_]:
            """Whether the cell at an offset from each cell is free."""
            return framed[_REACH + row :, _REACH + col :][:rows, :cols]

        # Moves are as clear backwards as forwards, so the mask of moves away from a cell is also
        # the mask of moves into it, from the cell at the offset.
        self._exists = np.empty((rows * cols, len(_MOVES)), dtype=np.bool_)
        for i, (move, between) in enumerate(_MOVES.items()):
            exists = free & is_free(*move)
            for cell in between:
                exists &= is_free(*cell)
            self._exists[:, i] = exists.ravel()
        flat = np.arange(rows * cols, dtype=np.int32)[:, None]
        self._origins = (flat + (_OFFSETS @ (cols, 1)).astype(np.int32))[self._exists]
        self._lengths = np.broadcast_to(_LENGTHS, self._exists.shape)[self._exists]
        ends = np.cumsum(np.count_nonzero(self._exists, axis=1), dtype=np.int32)
        self._first = np.concatenate([np.zeros(1, dtype=np.int32), ends])

    def entering(self, centre: npt.NDArray[np.float64], radius: float) -> npt.NDArray[np.int_]:
        """Moves that come into a disc from outside.

        Args:
            centre: (2,) point.
            radius: of the disc, in cells.

        Returns:
            (n,) numbers of moves, for `field`.
        """
        low = np.maximum(np.floor(centre - radius).astype(int) - _REACH, 0)
        high = np.minimum(np.ceil(centre + radius).astype(int) + _REACH, self._shape)
        near = low + np.argwhere(np.ones(np.maximum(high - low, 0)))
        exists = self._exists[near @ (self._shape[1], 1)]
        numbers = self._first[near @ (self._shape[1], 1)][:, None] + np.cumsum(exists, axis=1) - 1
        arrive = near[:, None] + 0.5
        enter = exists & enters(arrive + _OFFSETS, arrive, centre, radius)
        return np.asarray(numbers[enter])

    def field(self, goal: Cell, without: npt.NDArray[np.int_]) -> Field:
        """The way to a free cell from everywhere.

        Args:
            goal: the cell where the ways end.
            without: (n,) numbers of moves that no way may use.
        """
        lengths = self._lengths.copy()
        lengths[without] = np.inf
        cells = len(self._exists)
        cost, onward = csgraph.dijkstra(
            sparse.csr_array((lengths, self._origins, self._first), shape=(cells, cells)),
            indices=goal[0] * self._shape[1] + goal[1],
            return_predecessors=True,
            limit=np.finfo(np.float64).max,  # a move of infinite length leads nowhere
        )
        return Field(cost.reshape(self._shape), onward)
