"""How a command ended, for tests that run `companion` in their own process (conftest.py)."""

from __future__ import annotations

import sys
from collections.abc import Callable
from typing import NamedTuple

UNDRAWN = (
    sys.executable,
    "-c",
    "from companion.cli import main; from companion.flights import run_folders; "
    "run_folders.draw_here = lambda *_: None; main()",
)
"""`companion` in a process of its own, without pictures of flights: each takes as long as one."""


class Ended(NamedTuple):
    """How a command ended."""

    code: int
    out: str
    err: str


Companion = Callable[..., Ended]
"""Runs `companion ARGUMENTS`."""
