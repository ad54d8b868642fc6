"""What the operator has said beforehand of the vehicle that is to be armed."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum


class UploadPolicy(StrEnum):
    """What becomes of the autopilot's fence, or rally points, before arming (`upload_check.py`).

    UPLOAD writes the mission's where there is nothing, or what this companion wrote; KEEP flies
    with what is there; REPLACE writes the mission's in its place; NONE does not ask for it.
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
        rally_points: what becomes of its autopilot's rally points.
    """

    accepts_weak_failsafes: bool = False
    fence: UploadPolicy = UploadPolicy.UPLOAD
    rally_points: UploadPolicy = UploadPolicy.UPLOAD


USUAL_ARMING = ArmingTerms()
