"""How a command ended, for tests that run `companion` in their own process (conftest.py)."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple


class Ended(NamedTuple):
    """How a command ended."""

    code: int
    out: str
    err: str


Companion = Callable[..., Ended]
"""Runs `companion ARGUMENTS`."""
