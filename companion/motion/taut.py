"""How is a path along cells pulled tight? Its detours are cut off where a straight leg is clear.

The corners of a path are cell centres; the points between them that a cut needs to get close to an
obstacle's corner come from dividing the legs.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from companion.motion.sight import Points

Clear = Callable[[Points, Points], npt.NDArray[np.bool_]]

_TAUT = 0.1  # cells; a path is taut when cutting it again gains less


def pulled_tight(path: Points, is_clear: Clear) -> Points:
    """The path with its detours cut off, from both ends in turn, until it is as good as taut.

    Args:
        path: (n, 2) in cells.
        is_clear: whether legs (..., 2) may be flown, from the first points to the second ones.
    """

    def is_clear_backwards(a: Points, b: Points) -> npt.NDArray[np.bool_]:
        return is_clear(b, a)

    before = math.inf
    while before - length(path) > _TAUT:
        before = length(path)
        path = _cut(_divided(path), is_clear)
        path = _cut(_divided(path)[::-1], is_clear_backwards)[::-1]
    return path


def length(path: npt.NDArray[np.float64]) -> float:
    """Length of all legs of a path (n, 2) or (n, 3)."""
    return float(np.linalg.norm(np.diff(path, axis=0), axis=1).sum())


def _cut(path: Points, is_clear: Clear) -> Points:
    """The path with legs from each point that is kept to the furthest one in sight."""
    kept = [0]
    while kept[-1] < len(path) - 1:
        here = kept[-1]
        in_sight = np.flatnonzero(is_clear(path[here], path[here + 2 :]))
        kept.append(here + 2 + int(in_sight[-1]) if in_sight.size else here + 1)
    return path[kept]


def _divided(path: Points) -> Points:
    """The path with points on its legs, at most one cell apart."""
    parts = np.maximum(np.ceil(np.linalg.norm(np.diff(path, axis=0), axis=1)), 1).astype(int)
    leg = np.repeat(np.arange(len(parts)), parts)
    share = (np.arange(len(leg)) - np.repeat(np.cumsum(parts) - parts, parts)) / parts[leg]
    inner = path[leg] + share[:, None] * (path[leg + 1] - path[leg])
    return np.vstack([inner, path[-1:]])
