"""The payload: scripted answers to commands, with the timing of the command protocol.

The script has one result inside each circle and another elsewhere, each after a given time. The
rules are those of the command protocol (https://mavlink.io/en/services/command.html):

1. A long command is answered IN_PROGRESS at once, and again when it is repeated.
2. A second requester is TEMPORARILY_REJECTED until the first command is done.
3. An unknown command is UNSUPPORTED.
4. If a command is repeated soon after its final answer, that answer was lost: the same answer is
   sent again, and the command is not executed twice. A later repetition is a new command, whose
   first sending was lost.

    state     a command arrives          its time is over
    idle      working
    working   working (rules 1, 2)       answered, the final answer is sent
    answered  working, or rule 4

A scenario event may replace the script by a single answer, or by silence.
"""

from __future__ import annotations

from dataclasses import dataclass

from companion.geometry import Ned, NorthEast, horizontal_distance
from sitl.results import MavResult

DEFAULT_AFTER_S = 1.0
PROGRESS_S = 1.0
REPEATED_WITHIN_S = 3.0  # longer than any client waits before it sends a command again


@dataclass(frozen=True, slots=True)
class PayloadAnswer:
    """A result, and when it is sent.

    Attributes:
        is_silent: no answer at all is sent.
        tells_progress: IN_PROGRESS is repeated each second with the percentage done.
        is_lost: the final answer is lost at first, and heard when it is requested again.
    """

    result: MavResult
    after_s: float = DEFAULT_AFTER_S
    is_silent: bool = False
    tells_progress: bool = False
    is_lost: bool = False


@dataclass(frozen=True, slots=True)
class PayloadSite:
    """A circle with its answer."""

    centre: NorthEast
    radius_m: float
    answer: PayloadAnswer


@dataclass(frozen=True, slots=True)
class PayloadScript:
    """The answers of a payload.

    Attributes:
        component: its MAVLink component id.
        command: the only command that it knows.
        sites: the first circle that contains the vehicle decides.
        otherwise: the answer outside all circles.
    """

    component: int
    command: int
    sites: tuple[PayloadSite, ...] = ()
    otherwise: MavResult = MavResult.DENIED


Requester = tuple[int, int]
"""System and component that sent a command."""


@dataclass(frozen=True, slots=True)
class CommandAck:
    """A COMMAND_ACK to a requester; progress in percent."""

    requester: Requester
    result: MavResult
    progress: int = 0


@dataclass(slots=True)
class _Working:
    """A command under way."""

    requester: Requester
    answer: PayloadAnswer
    start_s: float
    told_s: float

    def progress(self, now_s: float) -> int:
        """The share that is done, percent; 0 if progress is not reported."""
        if not self.answer.tells_progress:
            return 0
        return min(100, int(100 * (now_s - self.start_s) / max(self.answer.after_s, 1e-9)))


@dataclass(frozen=True, slots=True)
class _Answered:
    """The last command has received its final answer."""

    ack: CommandAck
    at_s: float

    def repeats(self, requester: Requester, now_s: float) -> bool:
        """Whether a repeated command is the same one again (rule 4)."""
        return self.ack.requester == requester and now_s <= self.at_s + REPEATED_WITHIN_S


class Payload:
    """Executes one command at a time.

    Attributes:
        override: the answer everywhere; None means by the script.
    """

    def __init__(self, script: PayloadScript) -> None:
        self.script = script
        self.override: PayloadAnswer | None = None
        self._state: _Working | _Answered | None = None

    def receive(
        self,
        requester: Requester,
        command: int,
        position: Ned,
        now_s: float,
        *,
        is_repeated: bool = False,
    ) -> CommandAck | None:
        """The immediate answer; None means silence. `step` may return more."""
        answer = self.override or self._answer_at(position)
        if answer.is_silent:
            return None
        if command != self.script.command:
            return CommandAck(requester, MavResult.UNSUPPORTED)
        state = self._state
        if not isinstance(state, _Working):
            if is_repeated and state and state.repeats(requester, now_s):
                return state.ack
            self._state = state = _Working(requester, answer, now_s, now_s)
        if state.requester != requester:
            return CommandAck(requester, MavResult.TEMPORARILY_REJECTED)
        return CommandAck(requester, MavResult.IN_PROGRESS, state.progress(now_s))

    def step(self, now_s: float) -> CommandAck | None:
        """The answer that is due now, if any; a final one once per command."""
        state = self._state
        if not isinstance(state, _Working):
            return None
        if now_s >= state.start_s + state.answer.after_s:
            ack = CommandAck(state.requester, state.answer.result)
            self._state = _Answered(ack, now_s)
            is_silent = self.override is not None and self.override.is_silent
            return None if is_silent or state.answer.is_lost else ack
        if state.answer.tells_progress and now_s >= state.told_s + PROGRESS_S:
            state.told_s += PROGRESS_S
            return CommandAck(state.requester, MavResult.IN_PROGRESS, state.progress(now_s))
        return None

    def _answer_at(self, position: Ned) -> PayloadAnswer:
        for site in self.script.sites:
            if horizontal_distance(position, site.centre) <= site.radius_m:
                return site.answer
        return PayloadAnswer(self.script.otherwise)
