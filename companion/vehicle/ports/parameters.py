"""The parameters of an autopilot."""

from __future__ import annotations

from typing import Protocol


class AutopilotParameters(Protocol):
    """The parameters of a vehicle's autopilot."""

    def read(self, name: str) -> float | None:
        """The value of a parameter; requests it, and returns None until it was answered."""
