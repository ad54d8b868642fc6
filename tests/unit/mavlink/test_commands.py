"""The command protocol: when a command is sent again, and which answer is final."""

from __future__ import annotations

from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from companion.mavlink.commands import CommandSender, result_name
from companion.mavlink.framing import MavlinkCodec, dialect

RESEND_S, SILENCE_S, PROGRESS_S, REJECTION_PAUSE_S, MAX_REJECTIONS = 0.5, 5.0, 10.0, 1.0, 10
"""The numbers of the protocol's rules, written down once more on purpose."""
PAYLOAD = (1, 25)
USER_1 = dialect.MAV_CMD_USER_1
RESULTS = {entry.name[11:]: number for number, entry in dialect.enums["MAV_RESULT"].items()}


def ack(result: str, sender: tuple[int, int] = PAYLOAD, command: int = USER_1) -> Any:
    """A COMMAND_ACK after its way over the wire."""
    message = dialect.MAVLink_command_ack_message(command, RESULTS[result])
    return MavlinkCodec(0, 0).parse(MavlinkCodec(*sender).pack(message))[0]


class Talk:
    """One command to the payload, polled every 10 ms."""

    def __init__(self, timeout_s: float | None = None) -> None:
        self.sender = CommandSender()
        parameters = (1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0)
        self.ticket = self.sender.start(0.0, PAYLOAD, USER_1, parameters, timeout_s)
        self.sent: list[tuple[float, Any]] = []
        self.now_s = 0.0

    def wait(self, duration_s: float) -> None:
        for _ in range(round(duration_s / 0.01)):
            self.sent += [(self.now_s, message) for message in self.sender.due(self.now_s)]
            self.now_s = round(self.now_s + 0.01, 2)

    def hear(self, result: str) -> None:
        self.sender.receive(self.now_s, ack(result))

    @property
    def result(self) -> str | None:
        return self.sender[self.ticket].result

    @property
    def times(self) -> list[float]:
        return [time_s for time_s, _ in self.sent]


def test_it_is_sent_again_until_it_is_answered_and_counted() -> None:
    talk = Talk()
    talk.wait(1.8)
    assert talk.times == [0.0, RESEND_S, 2 * RESEND_S, 3 * RESEND_S]
    assert [message.confirmation for _, message in talk.sent] == [0, 1, 2, 3]
    message = talk.sent[0][1]
    assert (message.target_system, message.target_component) == PAYLOAD
    assert message.command == USER_1
    assert [getattr(message, f"param{i}") for i in range(1, 8)] == [1, 2, 3, 4, 5, 6, 7]
    talk.hear("ACCEPTED")
    talk.wait(5.0)
    assert len(talk.sent) == 4
    assert talk.result == "ACCEPTED"
    assert not talk.sender[talk.ticket].has_failed


def test_silence_is_a_failure() -> None:
    talk = Talk()
    talk.wait(SILENCE_S)
    assert talk.result is None
    talk.wait(0.1)
    assert talk.result == "NO_ANSWER"
    assert talk.sender[talk.ticket].has_failed
    assert len(talk.sent) == SILENCE_S / RESEND_S


def test_in_progress_lengthens_the_wait_and_ends_the_asking() -> None:
    talk = Talk()
    talk.wait(0.1)
    for _ in range(3):
        talk.hear("IN_PROGRESS")
        talk.wait(9.0)
    assert len(talk.sent) == 1
    assert talk.result is None
    talk.wait(PROGRESS_S - 9.0)
    assert talk.result is None
    talk.wait(0.1)
    assert talk.result == "NO_ANSWER"
    assert talk.sender[talk.ticket].in_words == "no final answer"


def test_a_temporary_rejection_is_tried_again_after_a_pause() -> None:
    talk = Talk()
    talk.wait(0.1)
    talk.hear("TEMPORARILY_REJECTED")
    rejected_s = talk.now_s
    talk.wait(1.2)
    assert talk.times[1] == pytest.approx(rejected_s + REJECTION_PAUSE_S, abs=0.011)
    assert len(talk.sent) == 2


def test_the_silence_after_a_rejection_is_counted_from_its_pause() -> None:
    talk = Talk()
    talk.wait(4.9)
    talk.hear("TEMPORARILY_REJECTED")
    talk.wait(REJECTION_PAUSE_S + SILENCE_S)
    assert talk.result is None
    talk.wait(0.1)
    assert talk.result == "NO_ANSWER"


def test_after_ten_rejections_the_next_is_final() -> None:
    talk = Talk()
    for _ in range(MAX_REJECTIONS):
        talk.wait(1.1)
        talk.hear("TEMPORARILY_REJECTED")
        assert talk.result is None
    talk.wait(1.1)
    talk.hear("TEMPORARILY_REJECTED")
    assert talk.result == "TEMPORARILY_REJECTED"
    assert talk.sender[talk.ticket].has_failed


def test_a_rejection_of_a_repetition_that_was_under_way_changes_nothing() -> None:
    """The payload works on the command already, and rejects what comes meanwhile."""
    talk = Talk()
    talk.wait(0.6)
    talk.hear("IN_PROGRESS")
    for _ in range(MAX_REJECTIONS + 1):
        talk.wait(0.1)
        talk.hear("TEMPORARILY_REJECTED")
    talk.wait(5.0)
    assert len(talk.sent) == 2
    assert talk.result is None
    talk.hear("ACCEPTED")
    assert talk.result == "ACCEPTED"


# -- A sender that says how long it waits ----------------------------------------------------------


@pytest.mark.parametrize(
    ("heard", "words"),
    [
        ([], "no answer in 15 s"),
        ([(0.2, "IN_PROGRESS")], "no final answer in 15 s"),
        ([(14.0, "IN_PROGRESS")], "no final answer in 15 s"),
        ([(0.2, "TEMPORARILY_REJECTED")], "no answer in 15 s"),
        ([(t + 0.5, "TEMPORARILY_REJECTED") for t in range(14)], "no answer in 15 s"),
    ],
)
def test_the_sender_says_how_long_it_waits_whatever_is_heard(
    heard: list[tuple[float, str]], words: str
) -> None:
    talk = Talk(timeout_s=15.0)
    for at_s, answer in heard:
        talk.wait(at_s - talk.now_s)
        talk.hear(answer)
    talk.wait(14.99 - talk.now_s)
    assert talk.result is None
    talk.wait(0.1)
    assert talk.result == "NO_ANSWER"
    assert talk.sender[talk.ticket].in_words == words


@pytest.mark.parametrize("first", ["IN_PROGRESS", "TEMPORARILY_REJECTED", None])
@pytest.mark.parametrize("late_s", [6.0, 12.0, 14.9])
def test_a_late_acceptance_counts_within_the_senders_time(first: str | None, late_s: float) -> None:
    talk = Talk(timeout_s=15.0)
    talk.wait(0.2)
    if first is not None:
        talk.hear(first)
    talk.wait(late_s - 0.2)
    talk.hear("ACCEPTED")
    talk.wait(5.0)
    assert talk.result == "ACCEPTED"


def test_the_senders_time_may_be_shorter_than_the_protocols() -> None:
    talk = Talk(timeout_s=2.0)
    talk.wait(0.1)
    talk.hear("IN_PROGRESS")
    talk.wait(2.0)
    assert talk.result == "NO_ANSWER"


# -- Final answers ---------------------------------------------------------------------------------


@pytest.mark.parametrize("result", ["DENIED", "UNSUPPORTED", "FAILED", "COMMAND_INT_ONLY"])
def test_every_other_result_is_final(result: str) -> None:
    talk = Talk()
    talk.wait(0.1)
    talk.hear(result)
    talk.wait(10.0)
    assert talk.result == result
    assert talk.sender[talk.ticket].has_failed
    assert len(talk.sent) == 1


def test_a_failure_that_follows_an_acceptance_counts() -> None:
    """PX4 accepts DO_SET_MODE at once and refuses it 10 ms later."""
    talk = Talk()
    talk.wait(0.1)
    talk.hear("ACCEPTED")
    talk.hear("DENIED")
    assert talk.result == "DENIED"


@pytest.mark.parametrize(
    "other",
    [
        ack("ACCEPTED", sender=(1, 26)),
        ack("ACCEPTED", sender=(2, 25)),
        ack("ACCEPTED", command=USER_1 + 1),
    ],
)
def test_an_answer_from_elsewhere_or_to_another_command_is_none(other: Any) -> None:
    talk = Talk()
    talk.sender.receive(0.0, other)
    assert talk.result is None


def test_an_answer_belongs_to_the_command_that_was_sent_last() -> None:
    sender = CommandSender()
    first = sender.start(0.0, PAYLOAD, USER_1, (0.0,) * 7)
    second = sender.start(0.0, PAYLOAD, USER_1, (1.0,) * 7)
    sender.due(0.0)
    sender.receive(0.0, ack("ACCEPTED"))
    assert (sender[first].result, sender[second].result) == (None, "ACCEPTED")


def test_commands_under_way_do_not_disturb_each_other() -> None:
    sender = CommandSender()
    tickets = [sender.start(0.0, (1, c), USER_1, (0.0,) * 7) for c in (25, 26)]
    assert [m.target_component for m in sender.due(0.0)] == [25, 26]
    sender.receive(0.1, ack("ACCEPTED", sender=(1, 26)))
    assert [sender[t].result for t in tickets] == [None, "ACCEPTED"]
    assert [m.target_component for m in sender.due(1.0)] == [25]


def test_a_forgotten_command_is_neither_sent_nor_answered() -> None:
    talk = Talk()
    talk.sender.forget(talk.ticket)
    talk.sender.forget(talk.ticket)
    talk.hear("ACCEPTED")
    talk.wait(1.0)
    assert talk.sent == []
    with pytest.raises(KeyError):
        talk.sender[talk.ticket]


def test_the_confirmation_fits_into_its_byte() -> None:
    talk = Talk()
    for _ in range(300):
        talk.wait(0.6)
        talk.sender[talk.ticket].deadline_s = talk.now_s + SILENCE_S  # somebody keeps it alive
    confirmations = [message.confirmation for _, message in talk.sent]
    assert max(confirmations) == 255
    assert confirmations == sorted(confirmations)


STEPS = st.lists(st.tuples(st.floats(0.01, 6.0), st.sampled_from([*RESULTS, None])), max_size=15)


@pytest.mark.slow
@given(STEPS)
def test_whatever_is_answered_the_talk_ends_and_nothing_is_sent_after(
    steps: list[tuple[float, str | None]],
) -> None:
    talk = Talk()
    for duration_s, answer in steps:
        talk.wait(duration_s)
        if answer is not None:
            talk.hear(answer)
    talk.wait(PROGRESS_S + SILENCE_S)
    assert talk.result
    sent = len(talk.sent)
    talk.wait(2.0)
    assert len(talk.sent) == sent


def test_results_in_words() -> None:
    assert result_name(dialect.MAV_RESULT_TEMPORARILY_REJECTED) == "TEMPORARILY_REJECTED"
    assert result_name(6) == "CANCELLED"
    assert result_name(99) == "result 99"


# -- interruptions ---------------------------------------------------------------------------------


@pytest.mark.parametrize("answered_s", [1.0, 3.0, 20.0])
def test_a_command_that_is_left_is_not_sent_and_its_answer_counts(answered_s: float) -> None:
    talk = Talk()
    talk.wait(0.3)
    talk.sender.leave(talk.ticket)
    talk.wait(answered_s)
    talk.hear("ACCEPTED")
    talk.wait(1.0)
    talk.sender.come_back(talk.ticket)
    talk.wait(1.0)
    assert (talk.result, talk.times) == ("ACCEPTED", [0.0])


def test_who_comes_back_sends_it_again_as_long_as_its_time_lasts() -> None:
    talk = Talk()
    talk.wait(0.3)
    talk.sender.leave(talk.ticket)
    talk.wait(2.7)
    talk.sender.come_back(talk.ticket)
    talk.wait(1.0)
    assert talk.times == [0.0, 3.0, 3.5]
    assert talk.sent[1][1].confirmation == 1
    talk.sender.leave(talk.ticket)
    talk.wait(SILENCE_S)
    assert talk.result == "NO_ANSWER"


def at_work_when_abandoned(timeout_s: float | None = None) -> Talk:
    """A payload that is at work on a command of which nobody asks any more, and another one."""
    talk = Talk()
    talk.wait(0.3)
    talk.hear("IN_PROGRESS")
    talk.sender.abandon(talk.ticket)
    talk.ticket = talk.sender.start(talk.now_s, PAYLOAD, USER_1, (9.0,) * 7, timeout_s)
    return talk


@pytest.mark.parametrize("result", ["ACCEPTED", "FAILED"])
def test_the_same_command_waits_until_its_component_is_idle(result: str) -> None:
    talk = at_work_when_abandoned()
    talk.wait(8.0)
    assert talk.times == [0.0]
    talk.hear(result)
    talk.wait(0.2)
    assert talk.times == [0.0, 8.3] and talk.result is None
    talk.hear("ACCEPTED")
    assert talk.result == "ACCEPTED"


@pytest.mark.parametrize("timeout_s", [None, 3.0])
def test_its_own_time_begins_then_and_work_without_a_word_ends(timeout_s: float | None) -> None:
    talk = at_work_when_abandoned(timeout_s)
    talk.wait(PROGRESS_S + 1.0)
    assert talk.times[1] == pytest.approx(0.3 + PROGRESS_S, abs=0.02)
    talk.wait(SILENCE_S)
    assert talk.result == "NO_ANSWER"


def test_the_time_of_one_that_waits_and_is_left_begins_when_it_is_sent() -> None:
    talk = at_work_when_abandoned()
    talk.sender.leave(talk.ticket)
    talk.wait(3 * PROGRESS_S)
    talk.sender.come_back(talk.ticket)
    talk.wait(1.0)
    assert talk.result is None and len(talk.times) == 3


def test_only_the_same_command_to_the_same_component_waits() -> None:
    talk = at_work_when_abandoned()
    talk.sender.start(talk.now_s, (1, 26), USER_1, (0.0,) * 7)
    talk.sender.start(talk.now_s, PAYLOAD, USER_1 + 1, (0.0,) * 7)
    sent = [(m.target_component, m.command) for m in talk.sender.due(talk.now_s)]
    assert sent == [(26, USER_1), (25, USER_1 + 1)]


def test_one_that_is_abandoned_before_any_answer_holds_up_nothing() -> None:
    talk = Talk()
    talk.wait(0.3)
    talk.sender.abandon(talk.ticket)
    talk.sender.start(talk.now_s, PAYLOAD, USER_1, (0.0,) * 7)
    assert len(talk.sender.due(talk.now_s)) == 1
