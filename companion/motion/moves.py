"""Which moves lead from cell to cell?

Free cells are joined by 16 moves: to the 8 neighbours and the knight's moves, so that a path along
moves is at most 2.75 % longer than a straight one (1 / cos of half the angle between two moves). A
move exists if every cell that it crosses or touches is free; it is as clear backwards as forwards.
Some may be barred in one direction, as those that come into a region.

The moves at a cell are the bits of one number: bit i speaks of the cell at `OFFSETS[i]` from it.
So moves are taken out, and two maps compared, by one operation for each cell.

Cells are (row, column); a flat index is row * cols + col. Points are in cells (`sight.py`).
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cache

import numpy as np
import numpy.typing as npt

from companion.motion.sight import Points, enters

Cell = tuple[int, int]
Cells = npt.NDArray[np.intp]
"""Flat indices."""
Bits = npt.NDArray[np.uint16]
"""(rows, cols) moves at each cell."""
Lengths = npt.NDArray[np.float64]

_QUADRANTS = ((1, 1), (1, -1), (-1, 1), (-1, -1))
_MOVES: dict[Cell, tuple[Cell, ...]] = {  # move: the cells between that it crosses or touches
    **{move: () for move in ((1, 0), (-1, 0), (0, 1), (0, -1))},
    **{(r, c): ((r, 0), (0, c)) for r, c in _QUADRANTS},
    **{(r, 2 * c): ((0, c), (r, c)) for r, c in _QUADRANTS},
    **{(2 * r, c): ((r, 0), (r, c)) for r, c in _QUADRANTS},
}
OFFSETS = np.array(list(_MOVES))
_BACKWARDS = np.array([list(_MOVES).index((-row, -col)) for row, col in _MOVES])
_REACH = 2  # the longest component of a move
_FLAGS = (1 << np.arange(len(_MOVES))).astype(np.uint16)


@dataclass(frozen=True, slots=True, eq=False)
class Moves:
    """The moves that may be made, seen from both of their ends.

    Attributes:
        away: from each cell to the one at the offset.
        onto: to each cell from the one at the offset.
    """

    away: Bits
    onto: Bits

    def leading_away(self, cells: Cells) -> tuple[Cells, Lengths]:
        """Where the moves from some cells (n,) lead, and how long they are.

        Returns:
            (n, 16) cells, which may lie off the map where there is no such move.
            (n, 16) lengths in cells, inf where there is no such move.
        """
        return cells[:, None] + self.steps, lengths_of(self.away.ravel()[cells])

    def leading_onto(self, cells: Cells) -> tuple[Cells, Lengths]:
        """From where moves lead to some cells (n,), and how long they are; as above."""
        return cells[:, None] + self.steps, lengths_of(self.onto.ravel()[cells])

    @property
    def steps(self) -> Cells:
        """(16,) what the moves from a cell add to its flat index."""
        return np.asarray(OFFSETS @ (self.away.shape[1], 1))

    def without(self, others: Moves) -> Moves:
        """These moves but for some."""
        return Moves(self.away & ~others.away, self.onto & ~others.onto)


def moves_between(free: npt.NDArray[np.bool_]) -> Moves:
    """The moves between free cells.

    Args:
        free: (rows, cols); everything outside is not free.
    """
    rows, cols = free.shape
    framed = np.pad(free, _REACH)

    def is_free(row: int, col: int) -> npt.NDArray[np.bool_]:
        """Whether the cell at an offset from each cell is free."""
        return framed[_REACH + row :, _REACH + col :][:rows, :cols]

    bits = np.zeros(free.shape, dtype=np.uint16)
    for flag, (move, between) in zip(_FLAGS, _MOVES.items(), strict=True):
        exists = free & is_free(*move)
        for cell in between:
            exists &= is_free(*cell)
        bits |= exists * flag
    return Moves(bits, bits)


def moves_entering(shape: Cell, centre: Points, radius: float) -> Moves:
    """Moves that come into a disc from outside, whether cells are free or not.

    Args:
        shape: rows and columns of the map.
        centre: (2,) of the disc.
        radius: of the disc, in cells.
    """
    low = np.maximum(np.floor(centre - radius).astype(int) - _REACH, 0)
    high = np.minimum(np.ceil(centre + radius).astype(int) + _REACH, shape)
    near = low + np.argwhere(np.ones(np.maximum(high - low, 0)))
    origin = near[:, None] + OFFSETS
    enter = enters(origin + 0.5, near[:, None] + 0.5, centre, radius)
    cell, i = np.nonzero(enter & np.all((origin >= 0) & (origin < shape), axis=-1))
    moves = no_moves(shape)
    np.bitwise_or.at(moves.onto, tuple(near[cell].T), _FLAGS[i])
    np.bitwise_or.at(moves.away, tuple(origin[cell, i].T), _FLAGS[_BACKWARDS[i]])
    return moves


def no_moves(shape: Cell) -> Moves:
    """The empty set of moves on a map."""
    return Moves(np.zeros(shape, dtype=np.uint16), np.zeros(shape, dtype=np.uint16))


def all_of(sets: Iterable[Moves], shape: Cell) -> Moves:
    """The moves of all of some sets on a map."""
    moves = no_moves(shape)
    for other in sets:
        np.bitwise_or(moves.away, other.away, out=moves.away)
        np.bitwise_or(moves.onto, other.onto, out=moves.onto)
    return moves


def lengths_of(bits: Bits, out: Lengths | None = None) -> Lengths:
    """(n, 16) lengths of the moves at some cells (n,), inf where there is none."""
    return _table().take(bits, axis=0, out=out, mode="clip")


@cache
def _table() -> Lengths:
    """(65536, 16) the lengths that belong to each number.

    The numbers are wide, 8 MB in between: the C library then keeps as much at hand when a search
    gives it back, which makes large searches a third quicker.
    """
    numbers, flags = np.arange(1 << len(_MOVES)), 1 << np.arange(len(_MOVES))
    return np.where(numbers[:, None] & flags, np.hypot(*OFFSETS.T), np.inf)
