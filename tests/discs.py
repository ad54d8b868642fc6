"""Regions of places that are discs, in cells."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from companion.motion.regions import Regions


def disc(centre: Sequence[float] | npt.NDArray[np.float64], radius: float) -> Regions:
    """The region of one place."""
    return Regions(("X",), np.array([centre], dtype=np.float64), np.array([radius]))
