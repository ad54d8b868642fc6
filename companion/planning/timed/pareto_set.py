"""Sets of labels that are not dominated by earlier ones."""

from __future__ import annotations

from collections.abc import Sequence
from operator import le

import numpy as np

FEW = 24
"""Up to this many labels are compared one by one."""


class ParetoSet:
    """Vectors; in each component, smaller is better.

    >>> best = ParetoSet()
    >>> best.add((1, 5)), best.add((2, 4)), best.add((2, 6)), len(best)
    (True, True, False, 2)
    """

    def __init__(self) -> None:
        self._few: list[Sequence[int]] = []
        self._many = np.zeros((0, 0), np.int64)
        self._count = 0

    def __len__(self) -> int:
        return self._count

    def add(self, vector: Sequence[int]) -> bool:
        """Adds a vector, unless a known one is as good in all components; true if added."""
        if self._count < FEW:
            for other in self._few:
                if all(map(le, other, vector)):
                    return False
            self._few.append(vector)
            self._count += 1
            return True
        if self._count == FEW:
            self._many = np.array(self._few, np.int64)
        row = np.array(vector, np.int64)
        if bool((self._many[: self._count] <= row).all(axis=1).any()):
            return False
        if self._count == len(self._many):
            self._many = np.concatenate((self._many, np.zeros_like(self._many)))
        self._many[self._count] = row
        self._count += 1
        return True
