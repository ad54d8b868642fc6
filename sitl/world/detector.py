"""The target detector: reports what the scenario's events make it see."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(slots=True)
class TargetDetector:
    """The target detector on board.

    Attributes:
        component: its MAVLink component id.
    """

    component: int
    sees_target: bool = False
