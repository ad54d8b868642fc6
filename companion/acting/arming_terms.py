"""What the operator has said beforehand of the vehicle that is to be armed."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum


class FencePolicy(StrEnum):
    """What becomes of the autopilot's fence before arming (`fence_check.py`).

    UPLOAD writes the mission's where there is none, or one of this companion; KEEP flies within the
    one that is there; REPLACE writes the mission's in its place; NONE does not ask for it.
    """

    UPLOAD = "upload"
    KEEP = "keep"
    REPLACE = "replace"
    NONE = "none"


@dataclass(frozen=True, slots=True)
class ArmingTerms:
    """On which terms a vehicle is armed.

    Attributes:
        accepts_weak_failsafes: although its autopilot's failsafes are weak.
        fence: what becomes of its autopilot's fence.
    """

    accepts_weak_failsafes: bool = False
    fence: FencePolicy = FencePolicy.UPLOAD


USUAL_TERMS = ArmingTerms()
