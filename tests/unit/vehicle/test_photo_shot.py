"""One photo, message by message: when it is asked for, when again, and when it is done."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import pytest

from companion.mavlink.commands import result_name
from companion.mavlink.framing import MavlinkCodec, dialect
from companion.outcomes import Failed
from companion.vehicle.cameras import MavlinkCameras
from companion.vehicle.known_camera import RESEND_S
from companion.vehicle.photo_shot import PHOTO_S, SHOOT
from companion.vehicle.ports.cameras import IntendedShot, PhotoMade, ShotOutcome, ShotReady
from companion.vehicle.services import Moment
from companion.vehicle.wire import Wire

CAMERA, TICK_S = 100, 0.05
OWNER = ("photo(A)", 3, 0)
ACCEPTED, IN_PROGRESS = dialect.MAV_RESULT_ACCEPTED, dialect.MAV_RESULT_IN_PROGRESS
REJECTED = dialect.MAV_RESULT_TEMPORARILY_REJECTED


class Talk:
    """A camera that says what a test makes it say, and answers how many photos it has made.

    Attributes:
        count: what it answers; None for nothing.
        asked: photos that it was asked for, with the time of each.
    """

    def __init__(self) -> None:
        self.cameras = MavlinkCameras(Wire())
        self.count: int | None = 0
        self.is_idle = True
        self.has_heartbeat = True
        self.asked: list[tuple[float, Any]] = []
        self.now_s = 100.0
        self._arriving: list[Any] = []
        self._codec = MavlinkCodec(1, CAMERA)
        self.run(1.0)
        self.ticket = self.prepare()

    def prepare(
        self,
        owner: tuple[str, int, int] = OWNER,
        timeout_s: float | None = None,
        may_repeat: bool = False,
    ) -> int:
        self.ticket = self.cameras.prepare(CAMERA, owner, timeout_s, may_repeat)
        return self.ticket

    @property
    def outcome(self) -> ShotOutcome:
        return self.cameras.outcome(self.ticket)

    def says(self, message: Any) -> None:
        (parsed,) = self._codec.parse(self._codec.pack(message))
        self._arriving.append(parsed)

    def answers(self, result: int, to: int = 191) -> None:
        self.says(dialect.MAVLink_command_ack_message(SHOOT, result, 0, 0, 1, to))

    def image(self, index: int, result: int = 1) -> None:
        q = (1.0, 0.0, 0.0, 0.0)
        self.says(
            dialect.MAVLink_camera_image_captured_message(
                0, 0, 0, 0, 0, 0, 0, q, index, result, b""
            )
        )

    def storage(self, status: int, left_mib: float) -> None:
        self.says(
            dialect.MAVLink_storage_information_message(
                0, 1, 1, status, 100.0, 0.0, left_mib, 0.0, 0.0
            )
        )

    def tick(self) -> None:
        self.now_s += TICK_S
        moment = Moment(self.now_s, self.now_s, is_quiet=False)
        self.cameras.step(moment)
        if self.has_heartbeat and round(self.now_s / TICK_S) % 20 == 0:
            self.says(dialect.MAVLink_heartbeat_message(dialect.MAV_TYPE_CAMERA, 8, 0, 0, 4, 3))
        arriving, self._arriving = self._arriving, []
        for message in arriving:
            self.cameras.take(moment, message)
        for message in self.cameras.due(moment):
            if message.command == SHOOT:
                self.asked.append((self.now_s, message))
            elif message.param1 in (262, 1) and self.count is not None:
                status = dialect.MAVLink_camera_capture_status_message(
                    time_boot_ms=0,
                    image_status=int(not self.is_idle),
                    video_status=0,
                    image_interval=0.0,
                    recording_time_ms=0,
                    available_capacity=0.0,
                    image_count=self.count,
                )
                self.says(status)

    def run(self, seconds: float) -> None:
        for _ in range(round(seconds / TICK_S)):
            self.tick()

    def asks(self) -> Talk:
        """Until the photo was asked for."""
        self.run(0.3)
        assert isinstance(self.outcome, ShotReady)
        self.cameras.shoot(self.ticket)
        self.tick()
        assert len(self.asked) == 1
        return self


@pytest.fixture
def talk() -> Talk:
    return Talk()


def test_a_photo_is_asked_for_once_and_done_when_it_is_there(talk: Talk) -> None:
    talk.asks().answers(IN_PROGRESS)
    talk.run(8.0)
    talk.answers(ACCEPTED)
    talk.run(1.0)
    assert talk.outcome is None
    talk.image(0)
    talk.tick()
    assert talk.outcome == PhotoMade(1, 0)
    (_, message), *others = talk.asked
    assert not others
    asked_for = (message.target_system, message.target_component, message.param3, message.param4)
    assert asked_for == (0, CAMERA, 1.0, 1.0)


def test_the_camera_is_asked_for_its_count_before(talk: Talk) -> None:
    talk.count = 41
    talk.run(0.3)
    assert talk.outcome == ShotReady(sequence=42, image_count=41)
    assert talk.asked == []


def test_a_lost_message_is_made_up_for_by_the_count(talk: Talk) -> None:
    talk.asks().answers(IN_PROGRESS)
    talk.run(1.0)
    talk.count = 1
    talk.run(4.0)
    assert talk.outcome == PhotoMade(1, None)
    assert len(talk.asked) == 1


def test_without_an_answer_it_is_not_asked_for_again(talk: Talk) -> None:
    """The answer may be lost, and the camera at work for seconds, without a word of that."""
    talk.asks()
    talk.run(PHOTO_S - 1.0)
    assert len(talk.asked) == 1
    talk.count = 1
    talk.run(0.9)
    assert talk.outcome == PhotoMade(1, None)


@pytest.mark.parametrize("tells_work", [True, False])
def test_but_of_a_camera_that_says_when_it_is_at_work_or_where_that_does_no_harm(
    talk: Talk, tells_work: bool
) -> None:
    if tells_work:
        says_that_it_is_at_work(talk)
    else:
        talk.cameras.forget(talk.ticket)
        talk.prepare(may_repeat=True)
    talk.asks()
    talk.run(RESEND_S - 0.2)
    assert len(talk.asked) == 1
    talk.run(1.0)
    (first_s, first), (again_s, again) = talk.asked
    assert again_s - first_s >= RESEND_S
    assert (first.confirmation, again.confirmation) == (0, 1)
    assert first.param4 == again.param4
    talk.count = talk.count + 1 if talk.count is not None else 0
    talk.run(2.0)
    assert isinstance(talk.outcome, PhotoMade)


def says_that_it_is_at_work(talk: Talk) -> None:
    """While it makes another photo."""
    talk.asks()
    talk.is_idle = False
    talk.run(1.0)
    talk.is_idle = True
    talk.image(0)
    talk.tick()
    talk.count = 1
    talk.cameras.forget(talk.ticket)
    talk.asked.clear()
    talk.prepare(("photo(B)", 4, 0))


def test_a_camera_that_says_nothing_is_not_asked_again(talk: Talk) -> None:
    talk.asks()
    talk.count = None
    talk.run(PHOTO_S)
    assert len(talk.asked) == 1
    assert isinstance(talk.outcome, Failed)
    assert talk.outcome.reason == (
        "no answer of the camera (component 100) in 15 s; whether it was made is not known"
    )


def test_nor_is_one_that_is_at_work(talk: Talk) -> None:
    talk.asks()
    talk.is_idle = False
    talk.run(10.0)
    assert len(talk.asked) == 1


def test_after_in_progress_it_is_never_asked_again(talk: Talk) -> None:
    talk.asks().answers(IN_PROGRESS)
    talk.run(PHOTO_S)
    assert len(talk.asked) == 1
    assert isinstance(talk.outcome, Failed)
    assert "though the camera (component 100) has answered" in talk.outcome.reason


def test_a_rejection_is_tried_again_with_pauses_that_grow(talk: Talk) -> None:
    talk.asks()
    for _ in range(3):
        before = len(talk.asked)
        talk.answers(REJECTED)
        while len(talk.asked) == before:
            talk.tick()
    times = [time_s for time_s, _ in talk.asked]
    pauses = [b - a for a, b in pairwise(times)]
    assert pauses == pytest.approx([1.0, 2.0, 4.0], abs=0.2)
    talk.answers(IN_PROGRESS)
    talk.image(0)
    talk.run(0.1)
    assert talk.outcome == PhotoMade(1, 0)


@pytest.mark.parametrize(
    "result", [dialect.MAV_RESULT_DENIED, dialect.MAV_RESULT_UNSUPPORTED, dialect.MAV_RESULT_FAILED]
)
@pytest.mark.parametrize(
    ("status", "left_mib", "words"),
    [
        (2, 0.0, "; its storage is full"),
        (0, 0.0, "; it has no storage"),
        (2, 9.0, ""),
        (None, 0, ""),
    ],
)
def test_a_refusal_is_told_with_what_the_storage_says(
    talk: Talk, result: int, status: int | None, left_mib: float, words: str
) -> None:
    talk.asks().answers(result)
    talk.tick()
    if status is not None:
        talk.storage(status, left_mib)
    talk.run(2.0)
    answered = result_name(result).lower()
    assert talk.outcome == Failed(f"the camera has answered: {answered}{words}")
    assert len(talk.asked) == 1


def test_a_failed_capture_is_a_failure(talk: Talk) -> None:
    talk.asks().answers(ACCEPTED)
    talk.image(0, result=0)
    talk.run(2.0)
    assert talk.outcome == Failed("the camera says that the photo has failed")


def test_an_image_that_was_heard_before_is_not_ours(talk: Talk) -> None:
    talk.asks().answers(IN_PROGRESS)
    talk.image(0)
    talk.tick()
    talk.count = 1
    talk.prepare(("photo(B)", 4, 0))
    talk.cameras.forget(1)
    talk.asked.clear()
    talk.asks().answers(IN_PROGRESS)
    talk.image(0)  # sent again
    talk.run(0.2)
    assert talk.outcome is None
    talk.image(1)
    talk.tick()
    assert talk.outcome == PhotoMade(2, 1)


def test_numbers_rise_whatever_the_camera_counts(talk: Talk) -> None:
    talk.count = 7
    talk.asks()
    talk.cameras.forget(talk.ticket)
    talk.prepare(("photo(B)", 4, 0), timeout_s=20.0)
    talk.run(PHOTO_S + 1.0)
    assert talk.outcome == ShotReady(sequence=9, image_count=7)


def test_a_camera_that_is_not_there_is_told_at_once(talk: Talk) -> None:
    talk.cameras.forget(talk.ticket)
    talk.has_heartbeat, talk.count = False, None
    talk.run(6.0)
    talk.prepare()
    talk.run(1.2)
    assert isinstance(talk.outcome, Failed)
    assert talk.outcome.reason.startswith(
        "the camera (component 100) is offline: nothing heard for"
    )


def test_no_count_and_no_heartbeat_are_two_things(talk: Talk) -> None:
    talk.count = None
    talk.run(PHOTO_S + 0.2)
    told = "the camera (component 100) does not say in 15 s how many photos it has made"
    assert talk.outcome == Failed(told)


# -- the same photo again: another try, the end of a pause, another process -----------------------


def again(talk: Talk, count: int) -> Talk:
    """The photo was asked for, nobody knows what became of it; now it is due again."""
    talk.asks()
    talk.cameras.forget(talk.ticket)
    talk.count = count
    talk.prepare(timeout_s=20.0)
    talk.run(PHOTO_S - 1.0)
    assert not isinstance(talk.outcome, ShotReady), "it may still be made"
    talk.run(2.0)
    return talk


def test_one_that_was_made_meanwhile_is_not_made_again(talk: Talk) -> None:
    assert again(talk, 1).outcome == PhotoMade(1, None)
    assert len(talk.asked) == 1


def test_one_that_was_not_made_is_asked_for_again(talk: Talk) -> None:
    assert again(talk, 0).outcome == ShotReady(sequence=2, image_count=0)


def test_of_a_camera_that_counts_anew_nobody_knows(talk: Talk) -> None:
    talk.count = 5
    outcome = again(talk, 0).outcome
    assert outcome == Failed(
        "whether the photo was made is not known: it has counted 0 photos, and 5 before"
    )


@pytest.mark.parametrize("count", [3, 4])
def test_a_photo_of_another_process_is_asked_about(talk: Talk, count: int) -> None:
    talk.cameras.forget(talk.ticket)
    talk.cameras.recall(IntendedShot(CAMERA, *OWNER, sequence=8, image_count=3))
    talk.count = count
    talk.prepare(timeout_s=20.0)
    talk.run(PHOTO_S + 1.0)
    assert talk.outcome == (ShotReady(9, 3) if count == 3 else PhotoMade(4, None))


def test_another_photo_does_not_take_it_for_its_own(talk: Talk) -> None:
    talk.asks()
    talk.cameras.forget(talk.ticket)
    talk.count = 1
    talk.prepare(("photo(B)", 4, 0))
    talk.run(0.5)
    assert talk.outcome == ShotReady(sequence=2, image_count=1)


def test_another_photo_waits_until_it_cannot_be_made_any_more(talk: Talk) -> None:
    """Else it would be taken for the other one."""
    talk.asks()
    talk.cameras.forget(talk.ticket)
    talk.prepare(("photo(B)", 4, 0))
    talk.run(3.0)
    assert talk.outcome is None
    talk.count = None
    talk.image(0)
    talk.run(1.0)
    assert talk.outcome is None, "the count is older than the image"
    talk.count = 1
    talk.run(1.0)
    assert talk.outcome == ShotReady(sequence=2, image_count=1)


def test_that_it_may_still_be_made_is_told(talk: Talk) -> None:
    talk.asks()
    talk.cameras.forget(talk.ticket)
    talk.prepare(("photo(B)", 4, 0), timeout_s=4.0)
    talk.run(4.2)
    assert talk.outcome == Failed(
        "the camera (component 100) may still make a photo that it was asked for 4 s before"
    )


def test_one_that_was_not_made_is_not_taken_for_made_by_anothers(talk: Talk) -> None:
    """Asked for in vain; then another action makes one, and the first one is due again."""
    talk.asks()
    talk.cameras.forget(talk.ticket)
    talk.prepare(("photo(B)", 3, 0), timeout_s=20.0)
    talk.run(PHOTO_S + 1.0)
    talk.cameras.shoot(talk.ticket)
    talk.tick()
    talk.image(0)
    talk.run(0.1)
    made = talk.outcome
    assert made == PhotoMade(1, 0)
    talk.count = 1
    talk.cameras.forget(talk.ticket)
    talk.prepare()
    talk.run(1.0)
    assert talk.outcome == ShotReady(sequence=3, image_count=1)


def test_two_photos_of_one_camera_come_one_after_the_other(talk: Talk) -> None:
    first = talk.ticket
    talk.asks()
    second = talk.prepare(("photo(B)", 3, 0))
    talk.run(1.0)
    assert talk.cameras.outcome(second) is None
    talk.image(0)
    talk.tick()
    assert talk.cameras.outcome(first) == PhotoMade(1, 0)
    talk.cameras.forget(first)
    talk.count = 1
    talk.run(1.0)
    assert talk.cameras.outcome(second) == ShotReady(2, 1)


def test_while_nothing_is_heard_of_the_autopilot_nothing_is_asked() -> None:
    cameras = MavlinkCameras(Wire())
    cameras.prepare(CAMERA, OWNER, None)
    moment = Moment(5.0, 5.0, is_quiet=True)
    cameras.step(moment)
    assert cameras.due(moment) == []


def test_answers_to_others_are_not_ours(talk: Talk) -> None:
    talk.asks().answers(dialect.MAV_RESULT_DENIED, to=190)
    talk.run(1.0)
    assert talk.outcome is None
