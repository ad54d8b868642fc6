"""What the program around a flight does for it: a command in a terminal, or somebody's own program.

A flight prints nothing and handles no signals by itself, because these belong to its program.
"""

from __future__ import annotations

from collections.abc import Callable
from contextlib import AbstractContextManager
from typing import Protocol

from companion.app import Companion
from companion.flight_events.event import Stamped


class FrontEnd(Protocol):
    """Shows people what happens, and ends a flight if they ask for it. No call may block."""

    def say(self, line: str, is_error: bool = False) -> None:
        """Shows a line, or an error."""

    def tell(self, stamped: Stamped) -> None:
        """Shows an event of a run."""

    def attending(self, companion: Companion) -> AbstractContextManager[Callable[[], None]]:
        """While the context lasts, the program's signals reach the companion.

        Returns:
            A context with a function that the flight's loop calls in each step.
        """
