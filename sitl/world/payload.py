"""What does the payload answer to a command, and when?

A script: inside a circle a result after a time, elsewhere another one. The rules are those of the
command protocol (https://mavlink.io/en/services/command.html): a long command is answered
IN_PROGRESS at once and again when it is repeated; a second asker is TEMPORARILY_REJECTED until the
first is done; an unknown command is UNSUPPORTED. A command that is repeated soon after its final
answer, because that was lost, is answered the same again and not done twice; later it is a command
of its own whose first sending was lost. An event of the scenario may replace the script by one
answer, or by silence.
"""

from __future__ import annotations

from dataclasses import dataclass

from companion.geometry import Ned, NorthEast, horizontal_distance
from sitl.results import Result

DEFAULT_AFTER_S = 1.0
PROGRESS_S = 1.0
REPEATED_WITHIN_S = 3.0  # longer than any client waits before it asks again


@dataclass(frozen=True, slots=True)
class Answer:
    """What is answered, and when.

    Attributes:
        is_silent: nothing at all is answered.
        tells_progress: IN_PROGRESS is repeated each second with what is done, 0 to 100.
    """

    result: Result
    after_s: float = DEFAULT_AFTER_S
    is_silent: bool = False
    tells_progress: bool = False


@dataclass(frozen=True, slots=True)
class Site:
    """A circle with its answer."""

    centre: NorthEast
    radius_m: float
    answer: Answer


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
class Reply:
    """A COMMAND_ACK to an asker; progress in percent."""

    asker: Asker
    result: Result
    progress: int = 0


@dataclass(slots=True)
class _Job:
    asker: Asker
    answer: Answer
    start_s: float
    told_s: float

    def progress(self, now_s: float) -> int:
        """What is done, percent; 0 unless it is to be told."""
        if not self.answer.tells_progress:
            return 0
        return min(100, int(100 * (now_s - self.start_s) / max(self.answer.after_s, 1e-9)))


class Payload:
    """Works on one command at a time.

    Attributes:
        override: the answer everywhere; None is the script.
    """

    def __init__(self, script: PayloadScript) -> None:
        self.script = script
        self.override: Answer | None = None
        self._job: _Job | None = None
        self._last: Reply | None = None
        self._last_s = 0.0

    def ask(
        self, asker: Asker, command: int, position: Ned, now_s: float, *, is_repeated: bool = False
    ) -> Reply | None:
        """The answer to give at once, None is silence; more may follow from `step`."""
        answer = self.override or self._answer_at(position)
        if answer.is_silent:
            return None
        if command != self.script.command:
            return Reply(asker, Result.UNSUPPORTED)
        if self._job is None:
            is_recent = now_s <= self._last_s + REPEATED_WITHIN_S
            if is_repeated and is_recent and self._last and self._last.asker == asker:
                return self._last
            self._job = _Job(asker, answer, now_s, now_s)
        if self._job.asker != asker:
            return Reply(asker, Result.TEMPORARILY_REJECTED)
        return Reply(asker, Result.IN_PROGRESS, self._job.progress(now_s))

    def step(self, now_s: float) -> Reply | None:
        """What to answer now by itself, if anything; a final answer once for each command."""
        job = self._job
        if job is None:
            return None
        if now_s >= job.start_s + job.answer.after_s:
            self._job = None
            self._last, self._last_s = Reply(job.asker, job.answer.result), now_s
            return None if self.override and self.override.is_silent else self._last
        if job.answer.tells_progress and now_s >= job.told_s + PROGRESS_S:
            job.told_s += PROGRESS_S
            return Reply(job.asker, Result.IN_PROGRESS, job.progress(now_s))
        return None

    def _answer_at(self, position: Ned) -> Answer:
        for site in self.script.sites:
            if horizontal_distance(position, site.centre) <= site.radius_m:
                return site.answer
        return Answer(self.script.otherwise)
