"""Waiting for what another thread or process does."""

from __future__ import annotations

import time
from collections.abc import Callable

PATIENCE_S = 300.0
"""Wall time that no answer needs."""


def comes_true(is_so: Callable[[], bool], limit_s: float = PATIENCE_S) -> bool:
    """Whether it became so in time."""
    end_s = time.monotonic() + limit_s
    while not is_so() and time.monotonic() < end_s:
        time.sleep(0.01)
    return is_so()
