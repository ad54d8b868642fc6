"""Makes one photo by the camera protocol, version 2: asks once, and waits until it is made. No I/O.

Rules:
1. A camera that was not heard for ONLINE_S is absent; the photo fails at once.
2. Before the request the camera is asked for its count of photos; while it is busy, the photo
   waits. If the same photo was asked for before with unknown result, the count decides: if it has
   risen, the photo was made; if it is equal, the photo is asked for again; if it has fallen, nobody
   knows.
3. The photo is made when a CAMERA_IMAGE_CAPTURED arrives with capture_result 1 and an image_index
   that was not heard before; or, as that message may be lost, when the count has risen.
4. The photo is asked for once: a camera may take a second one for the same number, and the answer
   may be lost while it works. The request is repeated only when the camera has said that it is idle
   and has counted no more, after
   - TEMPORARILY_REJECTED, with a pause that grows: it did not accept the request;
   - RESEND_S without an answer, if the camera has shown before that it says when it is at work,
     or if the skill may be repeated.
5. A photo that was asked for, with unknown result, may still be made for PHOTO_S, or for the time
   of its skill if that is longer. Meanwhile no other photo is asked for, except by rule 4.
6. If the photo is refused or fails, the camera's storage is asked for the cause.

    state      leads to
    COUNTING   READY by rule 2; ENDED
    READY      ASKED, by the caller
    ASKED      ANSWERED; FAILING by a refusal; ENDED
    ANSWERED   FAILING by a refusal or a failed capture; ENDED
    FAILING    ENDED, with what the storage has to do with it

A photo ends as made or not made; from FAILING always as not made.

Only time in which the autopilot is heard counts (`heard_time.py`). Source:
https://mavlink.io/en/services/camera.html; the camera server of MAVSDK 4.1.
"""

from __future__ import annotations

import math
from enum import Enum, auto

from companion.mavlink.commands import result_name
from companion.mavlink.framing import Message, dialect
from companion.outcomes import Failed
from companion.vehicle.known_camera import RESEND_S, KnownCamera
from companion.vehicle.ports.cameras import PhotoMade, ShotOutcome, ShotOwner, ShotReady

GRACE_S = 1.0
"""A camera that was not heard may answer within this time, and then counts as present."""
PHOTO_S = 15.0
"""Time for a photo if the skill gives none; also the longest that a camera is assumed to need,
unless the skill gives it more."""
FIRST_ASK_S, ASK_S, SELDOM_S = 0.15, 0.5, 2.0
REJECTED_S, MOST_REJECTED_S = 1.0, 8.0
STORAGE_S = 1.5
SHOOT, STATUS, STORAGE = (
    dialect.MAV_CMD_IMAGE_START_CAPTURE,
    dialect.MAVLINK_MSG_ID_CAMERA_CAPTURE_STATUS,
    dialect.MAVLINK_MSG_ID_STORAGE_INFORMATION,
)
REQUEST, OLD_REQUEST = (
    dialect.MAV_CMD_REQUEST_MESSAGE,
    dialect.MAV_CMD_REQUEST_CAMERA_CAPTURE_STATUS,
)


class ShotState(Enum):
    """The states of a photo."""

    COUNTING = auto()
    READY = auto()
    ASKED = auto()
    ANSWERED = auto()
    FAILING = auto()
    ENDED = auto()


class PhotoShot:
    """One photo.

    Args:
        camera: makes it.
        owner: what it is for.
        timeout_s: time for the whole procedure, from the first step on.
        may_repeat: a second photo does no harm.
    """

    def __init__(
        self,
        camera: KnownCamera,
        owner: ShotOwner,
        timeout_s: float | None,
        may_repeat: bool = False,
    ) -> None:
        self.camera = camera
        self._owner = owner
        self._may_repeat = may_repeat
        self._limit_s = PHOTO_S if timeout_s is None else timeout_s
        self._begun_s: float | None = None
        self._state = ShotState.COUNTING
        self._outcome: ShotOutcome = None
        self._sequence = self._count = self._sent = self._rejected = self._asked = 0
        self._next_send_s = self._next_ask_s = -math.inf
        self._again_s = self._failing_s = math.inf
        self._failure = ""

    @property
    def outcome(self) -> ShotOutcome:
        """What became of the photo."""
        return self._outcome

    def shoot(self, now_s: float) -> None:
        """Asks for the photo from now on."""
        if self._state is not ShotState.READY:
            return
        self._state, self._outcome = ShotState.ASKED, None
        self.camera.sequence = self._sequence
        self._mark(now_s)
        self._next_send_s, self._next_ask_s = now_s, now_s + ASK_S

    def _mark(self, now_s: float) -> None:
        self.camera.mark(self._owner, self._count, now_s, max(PHOTO_S, self._limit_s))

    # -- in ------------------------------------------------------------------------------------

    def step(self, now_s: float) -> None:
        """Advances the photo, with what is known of the camera by now."""
        if self._begun_s is None:
            self._begun_s = now_s
        if self._state is ShotState.COUNTING:
            self._count_photos(now_s)
        elif self._state in (ShotState.ASKED, ShotState.ANSWERED):
            self._look_for_photo()
        is_over = now_s - self._begun_s >= self._limit_s
        if self._state is ShotState.FAILING:
            if is_over or now_s - self._failing_s >= STORAGE_S:
                self._end(Failed(self._failure))
        elif is_over and self._is_under_way:
            self._end(Failed(self._overdue(now_s)))

    def take_answer(self, now_s: float, ack: Message) -> None:
        """Takes the answer to our request for a photo."""
        if self._state not in (ShotState.ASKED, ShotState.ANSWERED):
            return
        result = result_name(ack.result)
        if result in ("IN_PROGRESS", "ACCEPTED"):
            self._state = ShotState.ANSWERED
            self._next_ask_s = now_s + SELDOM_S
        elif result == "TEMPORARILY_REJECTED":
            if self._state is ShotState.ASKED:  # else it answers a repetition
                pause_s = min(REJECTED_S * 2**self._rejected, MOST_REJECTED_S)
                self._rejected += 1
                self._again_s = self._next_ask_s = now_s + pause_s
                if self._rejected >= self._sent:
                    self.camera.settle()
        else:
            if self._sent == 1:
                self.camera.settle()
            self._fail(now_s, f"the camera has answered: {result.replace('_', ' ').lower()}")

    def take_image(self, now_s: float, message: Message) -> None:
        """Takes a CAMERA_IMAGE_CAPTURED."""
        index = message.image_index
        is_asked = self._state in (ShotState.ASKED, ShotState.ANSWERED) and self._sent > 0
        if not is_asked or index in self.camera.indices:
            return
        if message.capture_result != 1:
            self._fail(now_s, "the camera says that the photo has failed")
        elif index >= self._count or index == self._sequence:
            self._end(PhotoMade(self._count + 1, index))

    def take_storage(self, message: Message) -> None:
        """Takes a STORAGE_INFORMATION."""
        if self._state is not ShotState.FAILING:
            return
        if message.status == dialect.STORAGE_STATUS_EMPTY:
            self._failure += "; it has no storage"
        elif message.status == dialect.STORAGE_STATUS_UNFORMATTED:
            self._failure += "; its storage is not formatted"
        elif message.status == dialect.STORAGE_STATUS_READY and message.available_capacity <= 0:
            self._failure += "; its storage is full"
        self._end(Failed(self._failure))

    # -- out -----------------------------------------------------------------------------------

    def due(self, now_s: float, system: int) -> list[Message]:
        """What to send now."""
        is_asking = self._is_under_way or self._state is ShotState.FAILING
        if self._state is ShotState.ASKED and now_s >= self._next_send_s:
            self._next_send_s, self._next_ask_s = math.inf, now_s + FIRST_ASK_S
            self._again_s = now_s + RESEND_S
            parameters = (0.0, 0.0, 1.0, float(self._sequence), 0.0, 0.0, 0.0)
            self._mark(now_s)
            confirmation = min(self._sent, 255)
            self._sent += 1
            return [_command(system, self.camera.component, SHOOT, confirmation, parameters)]
        if not is_asking or self._state is ShotState.READY or now_s < self._next_ask_s:
            return []
        self._asked += 1
        is_often = self._state in (ShotState.ASKED, ShotState.FAILING) or self._asked <= 4
        self._next_ask_s = now_s + (ASK_S if is_often else 2 * ASK_S)
        wanted = STORAGE if self._state is ShotState.FAILING else STATUS
        is_old = wanted == STATUS and self._asked % 4 == 0
        command, first = (OLD_REQUEST, 1.0) if is_old else (REQUEST, float(wanted))
        return [_command(system, self.camera.component, command, 0, (first, *(0.0,) * 6))]

    # -- states --------------------------------------------------------------------------------

    @property
    def _is_under_way(self) -> bool:
        return self._state in (ShotState.COUNTING, ShotState.ASKED, ShotState.ANSWERED)

    def _count_photos(self, now_s: float) -> None:
        """Applies rules 1 and 2."""
        camera, mark = self.camera, self.camera.marks.get(self._owner)
        begun_s = now_s if self._begun_s is None else self._begun_s
        if now_s - begun_s >= GRACE_S and (absence := camera.absence(now_s)):
            self._end(Failed(absence))
            return
        count = camera.image_count
        if count is None or camera.status_s < begun_s:
            return
        if mark is not None and count > mark.image_count:
            self._end(PhotoMade(mark.image_count + 1, None))
        elif mark is not None and count < mark.image_count:
            counted = f"it has counted {count} photos, and {mark.image_count} before"
            self._end(Failed(f"whether the photo was made is not known: {counted}"))
        elif camera.may_be_asked(self._may_repeat):
            self._count, self._sequence = count, max(camera.sequence, count) + 1
            self._state, self._outcome = ShotState.READY, ShotReady(self._sequence, count)

    def _look_for_photo(self) -> None:
        """Applies rules 3 and 4 to the camera's count, for a photo whose message may be lost."""
        camera, count = self.camera, self.camera.image_count
        if not self._sent or count is None:
            return
        if count > self._count and camera.status_s > camera.marks[self._owner].sent_s:
            self._end(PhotoMade(self._count + 1, None))
            return
        is_unheard = self._state is ShotState.ASKED and count == self._count
        is_due = camera.status_s >= self._again_s and camera.may_be_asked(self._may_repeat)
        if is_unheard and is_due:
            self._again_s, self._next_send_s = math.inf, camera.status_s

    def _fail(self, now_s: float, why: str) -> None:
        self._state, self._failure, self._failing_s = ShotState.FAILING, why, now_s
        self._next_ask_s = now_s

    def _end(self, outcome: ShotOutcome) -> None:
        self._state, self._outcome = ShotState.ENDED, outcome

    def _overdue(self, now_s: float) -> str:
        """Why there is no photo when its time is over."""
        camera, after = self.camera, f"in {self._limit_s:g} s"
        who = f"the camera (component {camera.component})"
        if absence := camera.absence(now_s):
            return absence if self._state is ShotState.COUNTING else f"{absence}; {UNKNOWN}"
        if self._state is ShotState.COUNTING:
            if self._begun_s is None or camera.status_s < self._begun_s:
                return f"{who} does not say {after} how many photos it has made"
            if camera.open is not None and camera.is_idle:
                asked_s = now_s - camera.open.sent_s
                return f"{who} may still make a photo that it was asked for {asked_s:.0f} s before"
            return f"{who} is busy"
        if self._state is ShotState.ANSWERED:
            return f"no photo {after}, though {who} has answered; {UNKNOWN}"
        if self._rejected:
            return f"temporarily rejected {after} by {who}"
        return f"no answer of {who} {after}; {UNKNOWN}"


UNKNOWN = "whether it was made is not known"


def _command(
    system: int, component: int, command: int, confirmation: int, parameters: tuple[float, ...]
) -> Message:
    return dialect.MAVLink_command_long_message(
        system, component, command, confirmation, *parameters
    )
