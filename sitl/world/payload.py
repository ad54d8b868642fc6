"""What does the payload answer to a command, and when?

A script: inside a circle a result after a time, elsewhere another one. The rules are those of the
command protocol (https://mavlink.io/en/services/command.html): a long command is answered
IN_PROGRESS at once and again when it is repeated; a second asker is TEMPORARILY_REJECTED until the
first is done; an unknown command is UNSUPPORTED.
"""

from __future__ import annotations

from dataclasses import dataclass

from companion.geometry import Ned, NorthEast, horizontal_distance
from sitl.results import Result

DEFAULT_AFTER_S = 1.0


@dataclass(frozen=True, slots=True)
class Site:
    """A circle with its answer."""

    centre: NorthEast
    radius_m: float
    answer: Result
    after_s: float


@dataclass(frozen=True, slots=True)
class PayloadScript:
    """What the payload answers.

    Attributes:
        component: its MAVLink component id.
        command: the only command that it knows.
        sites: the first circle that holds the vehicle decides.
        otherwise: the answer outside all circles.
    """

    component: int
    command: int
    sites: tuple[Site, ...] = ()
    otherwise: Result = Result.DENIED


Asker = tuple[int, int]
"""System and component that sent a command."""


@dataclass(frozen=True, slots=True)
class _Job:
    asker: Asker
    answer: Result
    done_s: float


class Payload:
    """Works on one command at a time."""

    def __init__(self, script: PayloadScript) -> None:
        self.script = script
        self._job: _Job | None = None

    def ask(self, asker: Asker, command: int, position: Ned, now_s: float) -> Result:
        """The answer to give at once; a final one may follow from `finished`."""
        if command != self.script.command:
            return Result.UNSUPPORTED
        if self._job is None:
            answer, after_s = self._answer_at(position)
            self._job = _Job(asker, answer, now_s + after_s)
        return Result.IN_PROGRESS if self._job.asker == asker else Result.TEMPORARILY_REJECTED

    def finished(self, now_s: float) -> tuple[Asker, Result] | None:
        """Whom to send which final answer now, if any; once for each command."""
        job = self._job
        if job is None or now_s < job.done_s:
            return None
        self._job = None
        return job.asker, job.answer

    def _answer_at(self, position: Ned) -> tuple[Result, float]:
        for site in self.script.sites:
            if horizontal_distance(position, site.centre) <= site.radius_m:
                return site.answer, site.after_s
        return self.script.otherwise, DEFAULT_AFTER_S
