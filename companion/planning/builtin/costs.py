"""Costs of paths, as arrays of whole milliseconds."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Costs = NDArray[np.int64]
"""Milliseconds; UNREACHABLE_MS if there is no path."""
Marks = NDArray[np.bool_]
"""(T, M): which acceptance marks each target has."""
UNREACHABLE_MS = 1 << 50
"""The cost if there is no path: above all real costs, but thousands of it can be added up."""
