"""The faults that a scenario can cause, as values: of links, of answers, of the autopilot.

`ANSWERS` lists how an autopilot may answer a command. sitl/link/disturbance.py applies a
`LinkQuality`, sitl/autopilot/reboot.py a `Reboot`.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

from sitl.results import MavResult

ACCEPTED_LATE_S = 2.0
"""Time from IN_PROGRESS to ACCEPTED, where both are sent."""


class Port(StrEnum):
    """A port of the vehicle by its peer: the companion at 14540, the ground station at 14550."""

    COMPANION = "companion"
    GROUND = "ground"


class Direction(StrEnum):
    """A direction of a link."""

    FROM_VEHICLE = "from_vehicle"
    TO_VEHICLE = "to_vehicle"


@dataclass(frozen=True, slots=True)
class LinkQuality:
    """How a link treats datagrams in one direction; the default is a perfect link.

    Attributes:
        loss: share of lost datagrams; 1 cuts the link.
        doubled: share of duplicated datagrams.
        delay_s: delay of each datagram.
        jitter_s: additional delay, uniform from 0 to this; datagrams may overtake each other.
    """

    loss: float = 0.0
    doubled: float = 0.0
    delay_s: float = 0.0
    jitter_s: float = 0.0


@dataclass(frozen=True, slots=True)
class Reboot:
    """A restart of the autopilot.

    Attributes:
        silent_s: time until the autopilot is heard again.
        recovers: in the air, the vehicle holds its place meanwhile and is armed afterwards.
    """

    silent_s: float
    recovers: bool


class Answer(StrEnum):
    """How an autopilot answers a command; `ANSWERS` explains each."""

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
    """The effect of a command, and its answers.

    Attributes:
        has_effect: the command is executed, as far as possible.
        results: each with its delay in seconds.
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
"""Every answer that an autopilot may give, and whether the command is executed."""
