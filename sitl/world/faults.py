"""The faults that a scenario brings about, as values: of links, of answers, of the autopilot.

`ANSWERS` is the table of the ways in which an autopilot may take a command. What the links do with
a `LinkQuality` is in sitl/link/disturbance.py, a reboot in sitl/autopilot/reboot.py.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

from sitl.results import MavResult

ACCEPTED_LATE_S = 2.0
"""Time from IN_PROGRESS to ACCEPTED, where both come."""


class Port(StrEnum):
    """A port of the vehicle, by who is at its other end: the companion 14540, the ground 14550."""

    COMPANION = "companion"
    GROUND = "ground"


class Direction(StrEnum):
    """A direction on a link."""

    FROM_VEHICLE = "from_vehicle"
    TO_VEHICLE = "to_vehicle"


@dataclass(frozen=True, slots=True)
class LinkQuality:
    """What a link does to datagrams in one direction; by default nothing.

    Attributes:
        loss: share that is lost; 1 cuts the link.
        doubled: share that comes twice.
        delay_s: each comes so much later.
        jitter_s: and up to this later again, evenly spread: one overtakes another.
    """

    loss: float = 0.0
    doubled: float = 0.0
    delay_s: float = 0.0
    jitter_s: float = 0.0


@dataclass(frozen=True, slots=True)
class Reboot:
    """A restart of the autopilot.

    Attributes:
        silent_s: time until it is heard again.
        recovers: in the air it holds its place meanwhile, and is armed afterwards.
    """

    silent_s: float
    recovers: bool


class Answer(StrEnum):
    """A way to take a command; `ANSWERS` says what each is."""

    ACCEPTED = "ACCEPTED"
    ACCEPTED_WITHOUT_EFFECT = "ACCEPTED_WITHOUT_EFFECT"
    TEMPORARILY_REJECTED = "TEMPORARILY_REJECTED"
    DENIED = "DENIED"
    UNSUPPORTED = "UNSUPPORTED"
    FAILED = "FAILED"
    CANCELLED = "CANCELLED"
    IN_PROGRESS = "IN_PROGRESS"
    IN_PROGRESS_THEN_ACCEPTED = "IN_PROGRESS_THEN_ACCEPTED"
    NO_ANSWER = "NO_ANSWER"
    NO_ANSWER_WITHOUT_EFFECT = "NO_ANSWER_WITHOUT_EFFECT"


@dataclass(frozen=True, slots=True)
class Answering:
    """What becomes of a command.

    Attributes:
        has_effect: it is carried out, as far as it can be.
        results: each with the seconds after which it is told.
    """

    has_effect: bool
    results: tuple[tuple[float, MavResult], ...]


def _refused(result: MavResult) -> Answering:
    return Answering(has_effect=False, results=((0.0, result),))


ANSWERS: dict[Answer, Answering] = {
    Answer.ACCEPTED: Answering(True, ((0.0, MavResult.ACCEPTED),)),
    Answer.ACCEPTED_WITHOUT_EFFECT: Answering(False, ((0.0, MavResult.ACCEPTED),)),
    Answer.TEMPORARILY_REJECTED: _refused(MavResult.TEMPORARILY_REJECTED),
    Answer.DENIED: _refused(MavResult.DENIED),
    Answer.UNSUPPORTED: _refused(MavResult.UNSUPPORTED),
    Answer.FAILED: _refused(MavResult.FAILED),
    Answer.CANCELLED: _refused(MavResult.CANCELLED),
    Answer.IN_PROGRESS: _refused(MavResult.IN_PROGRESS),
    Answer.IN_PROGRESS_THEN_ACCEPTED: Answering(
        True, ((0.0, MavResult.IN_PROGRESS), (ACCEPTED_LATE_S, MavResult.ACCEPTED))
    ),
    Answer.NO_ANSWER: Answering(True, ()),
    Answer.NO_ANSWER_WITHOUT_EFFECT: Answering(False, ()),
}
"""Every answer that an autopilot may give, and whether the command has its effect."""
