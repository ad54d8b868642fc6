"""Whole searches of a map that no flight has changed yet are made once: most flights begin so.

A cost-to-go is never changed, so flights can share it; each keeps its own graph.
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace

import numpy as np
import pytest

from companion.motion import distance_maps
from companion.motion.cost_to_go import ALL, CostToGo, continued
from companion.motion.grid_graph import Cell

MOST = 200
"""Remembered ones, of some 200 kB each."""

_Key = tuple[tuple[int, ...], bytes, int]


class _Remembered:
    """`continued`, which looks up what it has searched before."""

    def __init__(self) -> None:
        self._known: OrderedDict[_Key, CostToGo] = OrderedDict()

    def __call__(self, to_go: CostToGo, max_cells: int, cell: Cell | None = None) -> CostToGo:
        goals = np.flatnonzero(np.isfinite(to_go.cost))
        if max_cells < ALL // 2 or cell is not None or len(goals) != 1:
            return continued(to_go, max_cells, cell)
        key = to_go.cost.shape, to_go.graph.outgoing.tobytes(), int(goals[0])
        if key not in self._known:
            self._known[key] = continued(to_go, max_cells)
            if len(self._known) > MOST:
                self._known.popitem(last=False)
        return replace(self._known[key], graph=to_go.graph)


@contextmanager
def searches_remembered() -> Iterator[None]:
    """Searches that begin here are remembered."""
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(distance_maps, "continued", _Remembered())
        yield
