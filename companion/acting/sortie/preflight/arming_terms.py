"""What the operator has decided beforehand about arming."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum


class UploadPolicy(StrEnum):
    """What happens to the autopilot's fence or rally points before arming (upload_check.py).

    UPLOAD writes the mission's if there is none, or one that this companion wrote; KEEP flies with
    the one that is there; REPLACE writes the mission's in its place; NONE does not ask for it.
    """

    UPLOAD = "upload"
    KEEP = "keep"
    REPLACE = "replace"
    NONE = "none"


@dataclass(frozen=True, slots=True)
class ArmingTerms:
    """The terms on which a vehicle is armed.

    Attributes:
        accepts_weak_failsafes: whether it is armed although its autopilot's failsafes are weak.
        fence: what happens to its autopilot's fence.
        rally_points: what happens to its autopilot's rally points.
    """

    accepts_weak_failsafes: bool = False
    fence: UploadPolicy = UploadPolicy.UPLOAD
    rally_points: UploadPolicy = UploadPolicy.UPLOAD


USUAL_ARMING = ArmingTerms()
