"""Before arming, reads what the autopilot stores for a mission, and writes it if allowed.

The autopilot's fence and its rally points take the same steps. They differ in what is required, and
in how the present content is judged (`UploadJudge`).

1. What somebody else has stored stays, and the mission is refused, unless the operator has decided
   which of the two to keep.
2. What has been written is read back and compared.
3. An autopilot that does not know its position on the earth stores nothing. That is reported, and
   the mission begins.
"""

from __future__ import annotations

from enum import Enum
from typing import Protocol

from companion.acting.sortie.preflight.arming_terms import UploadPolicy
from companion.outcomes import Failed, Outcome, Progress
from companion.transitions import StateTransition, TransitionTable
from companion.vehicle.ports.stores import AutopilotStore


class UploadStage(Enum):
    """The stages of a check."""

    LOCATING = "asking where the autopilot's frame lies"
    READING = "reading what it has"
    WRITING = "writing the mission's"
    READING_BACK = "reading it back"
    LISTENING = "listening to what the autopilot says of it"
    DONE = "done"


class UploadStep(Enum):
    """The events in a check."""

    NOT_ASKED = "nothing is wanted of it"
    LOCATED = "it is known where the frame lies"
    GONE_WITHOUT = "the autopilot has no position on the earth, or does not answer"
    KEPT = "what is there may stay"
    UNFIT = "the mission's has to be written"
    WRITTEN = "the autopilot has taken it"
    READ_BACK = "it is what was written"
    UNOPPOSED = "nothing was said against it"


_S, _T = UploadStage, UploadStep

TRANSITIONS = TransitionTable(
    StateTransition(_S.LOCATING, _T.NOT_ASKED, _S.DONE, "it is left alone"),
    StateTransition(_S.LOCATING, _T.LOCATED, _S.READING, "it is asked for what it has"),
    StateTransition(_S.READING, _T.KEPT, _S.DONE, "it fits the mission"),
    StateTransition(_S.READING, _T.UNFIT, _S.WRITING, "the mission's fits"),
    StateTransition(_S.WRITING, _T.WRITTEN, _S.READING_BACK, "it is asked for what it has"),
    StateTransition(_S.READING_BACK, _T.READ_BACK, _S.LISTENING, "time passes"),
    StateTransition(_S.LISTENING, _T.UNOPPOSED, _S.DONE, "it is in force, and this is reported"),
    *(
        StateTransition(stage, _T.GONE_WITHOUT, _S.DONE, "that is told")
        for stage in (_S.LOCATING, _S.READING, _S.WRITING, _S.READING_BACK)
    ),
)
"""The transitions of a check; at any stage it may end with why the mission is refused."""


class UploadJudge(Protocol):
    """What is required for one kind of content, and how the autopilot's content is judged."""

    @property
    def store(self) -> AutopilotStore:
        """The autopilot's store of this kind."""

    @property
    def is_asked(self) -> bool:
        """Whether the autopilot has to be asked at all."""

    def nowhere(self, reason: str) -> None:
        """Reports that the autopilot does not know its position on the earth, and why."""

    def unanswered(self, failed: Failed) -> Failed | None:
        """After a failed transfer: why the mission is refused; None if it is only reported."""

    def judge(self) -> UploadStep | Failed | None:
        """KEPT; UNFIT, having begun to write; why the mission is refused; or None to wait."""

    def compare(self) -> Failed | None:
        """Why what was read back is not what was written; None if it is."""

    def listen(self) -> UploadStep | Failed | None:
        """UNOPPOSED when it is in force; None while that is unknown."""


class UploadCheck:
    """One check.

    Args:
        judge: the judge for one kind.
        policy: what the operator has decided about it.
    """

    def __init__(self, judge: UploadJudge, policy: UploadPolicy) -> None:
        self._judge = judge
        is_left_alone = policy is UploadPolicy.NONE
        self._stage = UploadStage.DONE if is_left_alone else UploadStage.LOCATING

    def tick(self) -> Outcome:
        """DONE when the content is as required, or none is required; or why it is not."""
        step = self._work()
        if isinstance(step, Failed):
            return step
        if step is not None:
            self._stage = TRANSITIONS.next(self._stage, step)
        return Progress.DONE if self._stage is UploadStage.DONE else Progress.RUNNING

    def _work(self) -> UploadStep | Failed | None:
        """The work of the present stage in a tick; returns the step that ends the stage, if any."""
        match self._stage:
            case UploadStage.LOCATING:
                return self._locate()
            case UploadStage.READING:
                return self._read()
            case UploadStage.WRITING:
                return self._write()
            case UploadStage.READING_BACK:
                return self._read_back()
            case UploadStage.LISTENING:
                return self._judge.listen()
            case UploadStage.DONE:
                return None

    def _locate(self) -> UploadStep | Failed | None:
        store = self._judge.store
        if not self._judge.is_asked:
            return UploadStep.NOT_ASKED
        outcome = store.locate()
        if isinstance(outcome, Failed):
            self._judge.nowhere(outcome.reason)
            return UploadStep.GONE_WITHOUT
        if outcome is Progress.RUNNING:
            return None
        store.read()
        return UploadStep.LOCATED

    def _read(self) -> UploadStep | Failed | None:
        return self._failure() or (self._judge.judge() if self._is_done else None)

    def _write(self) -> UploadStep | Failed | None:
        if (failure := self._failure()) is not None or not self._is_done:
            return failure
        self._judge.store.read()
        return UploadStep.WRITTEN

    def _read_back(self) -> UploadStep | Failed | None:
        if (failure := self._failure()) is not None or not self._is_done:
            return failure
        return self._judge.compare() or UploadStep.READ_BACK

    @property
    def _is_done(self) -> bool:
        """Whether the present transfer has ended well."""
        return self._judge.store.outcome is Progress.DONE

    def _failure(self) -> UploadStep | Failed | None:
        """What a failure of the present transfer leads to; None if it has not failed."""
        outcome = self._judge.store.outcome
        if not isinstance(outcome, Failed):
            return None
        return self._judge.unanswered(outcome) or UploadStep.GONE_WITHOUT
