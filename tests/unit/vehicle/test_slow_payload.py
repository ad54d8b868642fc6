"""A skill's command and the simulator's payload, byte for byte: who waits how long for whom."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from autopilot import TICK_S, Meeting, of_type

from companion.mavlink.commands import result_name
from companion.mavlink.framing import MavlinkCodec, dialect
from companion.outcomes import Failed, Outcome, Progress
from sitl.results import MavResult
from sitl.world.payload import Payload, PayloadAnswer, PayloadScript

COMPONENT, USER_1 = 25, dialect.MAV_CMD_USER_1
OURS = (1, 191)
ABOVE_HOME = (0.0, 0.0, -2.0)


class Talk:
    """One command to a payload that takes its time, tick by tick.

    Args:
        meeting: the vehicle that sends it.
        answer: of the payload.
        timeout_s: of the skill.
        is_lost: says of an answer of the payload, by its time and result, that it never arrives.

    Attributes:
        works: how often the payload began to work.
        asked_s: when the command was sent.
    """

    def __init__(
        self,
        meeting: Meeting,
        answer: PayloadAnswer,
        timeout_s: float | None,
        is_lost: Callable[[float, str], bool] = lambda now_s, result: False,
    ) -> None:
        self.payload = Payload(PayloadScript(COMPONENT, USER_1))
        self.payload.override = answer
        self.works = 0
        self.asked_s: list[float] = []
        self._meeting = meeting
        self._codec = MavlinkCodec(1, COMPONENT)
        self._is_lost = is_lost
        self._on_the_way: list[bytes] = []
        meeting.tick()
        self._start_s = meeting.now_s
        self._ticket = meeting.vehicle.payloads.send(COMPONENT, USER_1, (), timeout_s)

    def outcome(self, limit_s: float = 60.0) -> Outcome:
        """What becomes of it."""
        for _ in range(round(limit_s / TICK_S)):
            self._tick()
            outcome = self._meeting.vehicle.payloads.outcome(self._ticket)
            if outcome is not Progress.RUNNING:
                return outcome
        raise AssertionError(f"still under way after {limit_s:.0f} s")

    @property
    def took_s(self) -> float:
        return self._meeting.now_s - self._start_s

    def _tick(self) -> None:
        arriving, self._on_the_way = self._on_the_way, []
        asked = of_type(self._meeting.tick(*arriving), "COMMAND_LONG")
        now_s = self._meeting.now_s - self._start_s
        was_working = self.payload.step(now_s)
        acks = [was_working]
        for message in asked:
            self.asked_s.append(now_s)
            is_repeated = message.confirmation > 0
            before = self.payload._state
            acks.append(
                self.payload.receive(OURS, USER_1, ABOVE_HOME, now_s, is_repeated=is_repeated)
            )
            self.works += self.payload._state is not before
        for ack in acks:
            if ack is not None and not self._is_lost(now_s, result_name(ack.result)):
                message = dialect.MAVLink_command_ack_message(USER_1, ack.result, 0, 0, *OURS)
                self._on_the_way.append(self._codec.pack(message))


@pytest.mark.parametrize("tells_progress", [False, True])
@pytest.mark.parametrize("after_s", [0.5, 6.0, 12.0, 14.5])
def test_a_payload_has_all_of_the_skills_time(
    meeting: Meeting, after_s: float, tells_progress: bool
) -> None:
    answer = PayloadAnswer(MavResult.ACCEPTED, after_s, tells_progress=tells_progress)
    talk = Talk(meeting, answer, timeout_s=15.0)
    assert talk.outcome() is Progress.DONE
    assert talk.took_s == pytest.approx(after_s, abs=3 * TICK_S)
    assert (len(talk.asked_s), talk.works) == (1, 1)


def test_a_payload_that_takes_longer_is_given_up_at_the_skills_time(meeting: Meeting) -> None:
    talk = Talk(meeting, PayloadAnswer(MavResult.ACCEPTED, 20.0), timeout_s=15.0)
    assert talk.outcome() == Failed("no final answer in 15 s")
    assert talk.took_s == pytest.approx(15.0, abs=2 * TICK_S)
    assert talk.works == 1


def test_a_payload_that_is_not_heard_at_first_is_asked_again_and_works_once(
    meeting: Meeting,
) -> None:
    """It answers our repetitions; the first answers are lost, longer than the protocol waits."""
    answer = PayloadAnswer(MavResult.ACCEPTED, 12.0)
    talk = Talk(meeting, answer, 15.0, is_lost=lambda now_s, _: now_s < 8.0)
    assert talk.outcome() is Progress.DONE
    assert talk.works == 1
    assert 8.0 <= talk.asked_s[-1] <= 8.5 + TICK_S  # in progress from then on


def test_a_silent_payload_is_asked_for_the_skills_time(meeting: Meeting) -> None:
    talk = Talk(meeting, PayloadAnswer(MavResult.ACCEPTED, is_silent=True), timeout_s=7.0)
    assert talk.outcome() == Failed("no answer in 7 s, and no heartbeat of component 25")
    assert talk.took_s == pytest.approx(7.0, abs=2 * TICK_S)


def test_without_a_time_of_the_skill_the_protocol_says_how_long(meeting: Meeting) -> None:
    talk = Talk(meeting, PayloadAnswer(MavResult.ACCEPTED, 12.0), timeout_s=None)
    assert talk.outcome() == Failed("no final answer")
    assert talk.took_s == pytest.approx(10.0, abs=3 * TICK_S)
