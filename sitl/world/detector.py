"""The target detector: reports the target while the scenario's events let it see one."""

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
