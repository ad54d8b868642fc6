"""MAV_RESULT of common.xml, by the names that scenarios and code use."""

from __future__ import annotations

from enum import IntEnum


class MavResult(IntEnum):
    """MAV_RESULT: the result of a command."""

    ACCEPTED = 0
    TEMPORARILY_REJECTED = 1
    DENIED = 2
    UNSUPPORTED = 3
    FAILED = 4
    IN_PROGRESS = 5
    CANCELLED = 6
