"""String pulling: shortens a path along cells by straight legs wherever they are clear.

The corners of the path are cell centres. A leg may need other points to pass close to an obstacle's
corner; these come from dividing the legs.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol

import numpy as np
import numpy.typing as npt

from companion.motion.line_of_sight import Points

_MIN_GAIN = 0.1  # cells; the last pass is the one that gains less
_BATCH = 16  # legs that are tested together; most of the furthest ones are clear


class LegTest(Protocol):
    """Tells which straight legs are clear."""

    def may_be_clear(self, a: Points, b: Points) -> npt.NDArray[np.bool_]:
        """(...) a quick test of many legs from a to b (..., 2): False only for blocked legs."""

    def are_clear(self, a: Points, b: Points) -> npt.NDArray[np.bool_]:
        """(...) whether the legs from a to b (..., 2) are clear."""


@dataclass(frozen=True, slots=True)
class _Reversed:
    """Legs flown from their second point to the first."""

    legs: LegTest

    def may_be_clear(self, a: Points, b: Points) -> npt.NDArray[np.bool_]:
        return self.legs.may_be_clear(b, a)

    def are_clear(self, a: Points, b: Points) -> npt.NDArray[np.bool_]:
        return self.legs.are_clear(b, a)


def pull_string(path: Points, legs: LegTest) -> Points:
    """The path (n, 2) without detours: shortened from both ends in turn until little is gained."""
    before = math.inf
    while len(path) > 2 and before - length(path) > _MIN_GAIN:
        before = length(path)
        path = _shortened(_divided(path), legs)
        path = _shortened(_divided(path)[::-1], _Reversed(legs))[::-1]
    return path


def length(path: npt.NDArray[np.float64]) -> float:
    """Length of all legs of a path (n, 2) or (n, 3).

    >>> length(np.array([[0.0, 0.0], [3.0, 4.0], [3.0, 5.0]]))
    6.0
    """
    return float(np.linalg.norm(np.diff(path, axis=0), axis=1).sum())


def _shortened(path: Points, legs: LegTest) -> Points:
    """The path with legs from each remaining point to the furthest one in sight."""
    kept = [0]
    while kept[-1] < len(path) - 1:
        kept.append(_furthest(path, kept[-1], legs))
    return path[kept]


def _furthest(path: Points, here: int, legs: LegTest) -> int:
    """The last point of a path to which a clear leg leads from another one; at least the next."""
    ahead = here + 2 + np.flatnonzero(legs.may_be_clear(path[here], path[here + 2 :]))
    for end in range(len(ahead), 0, -_BATCH):
        some = ahead[max(end - _BATCH, 0) : end]
        in_sight = some[legs.are_clear(path[here], path[some])]
        if in_sight.size:
            return int(in_sight[-1])
    return here + 1


def _divided(path: Points) -> Points:
    """The path with points on its legs, at most one cell apart."""
    parts = np.maximum(np.ceil(np.linalg.norm(np.diff(path, axis=0), axis=1)), 1).astype(int)
    leg = np.repeat(np.arange(len(parts)), parts)
    share = (np.arange(len(leg)) - np.repeat(np.cumsum(parts) - parts, parts)) / parts[leg]
    inner = path[leg] + share[:, None] * (path[leg + 1] - path[leg])
    return np.vstack([inner, path[-1:]])
