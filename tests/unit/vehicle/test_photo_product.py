"""A camera that may be slow, silent and lossy, in every combination: one photo, no word too many.

The camera is the simulator's. On its way something is lost or late, for each kind of message: what
it was asked, its answer, the image, its status. It may leave out IN_PROGRESS, and say that it is
idle while it is at work.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from enum import Enum
from itertools import product
from random import Random
from typing import Any

import pytest
from drawn import drawn
from hypothesis import given
from hypothesis import strategies as st

from companion.geometry import GlobalOrigin
from companion.mavlink.framing import MavlinkCodec
from companion.outcomes import Failed
from companion.vehicle.cameras import MavlinkCameras
from companion.vehicle.photo_shot import PHOTO_S, SHOOT
from companion.vehicle.ports.cameras import PhotoMade, ShotReady
from companion.vehicle.services import Moment
from companion.vehicle.wire import Wire
from sitl.flight.physics import FlightState
from sitl.link.camera_component import CameraComponent
from sitl.results import MavResult
from sitl.world.camera import Camera, CameraSpec

CAMERA, TICK_S = 100, 0.1
OWNER = ("photo(A)", 3, 0)
_ZERO = (0.0, 0.0, 0.0)
REST = FlightState(
    *(0.0, _ZERO, _ZERO, (1.0, 0.0, 0.0, 0.0), _ZERO, _ZERO, (0.0, 0.0, -9.8)),
    *((0.0,) * 4, (0.0,) * 4, 16.0, 0.0, 1.0, True),
)
BEFORE = 7
"""Photos that it has made before."""


class Fate(Enum):
    """What becomes of a kind of messages."""

    COMES = "comes"
    LATE = "late"
    LOST = "lost"


@dataclass(frozen=True)
class World:
    """A camera, and what becomes of what is said.

    Attributes:
        asked: of the first command alone; it does not come late.
        after_s: how long a photo takes.
        late_s: how late what is late comes.
        is_told: by IN_PROGRESS at once.
        tells_work: its status says when it is at work.
        fails: its photos do not succeed.
    """

    asked: Fate
    answer: Fate
    image: Fate
    is_status_answered: bool
    is_told: bool
    tells_work: bool
    fails: bool
    after_s: float
    late_s: float
    timeout_s: float | None = None
    may_repeat: bool = False


class Meeting:
    """Cameras as they are known, and the one that there is.

    Attributes:
        taken: commands that have reached the camera, but for those that it has rejected.
    """

    def __init__(self, world: World) -> None:
        self.world = world
        self.cameras = MavlinkCameras(Wire())
        spec = CameraSpec(CAMERA, after_s=world.after_s, images=BEFORE)
        self.camera = Camera(spec, Random(1))
        self.camera._fails = world.fails
        self.component = CameraComponent(1, self.camera, GlobalOrigin(47.0, 8.0, 400.0))
        self.now_s = 0.0
        self.sent = self.taken = 0
        self._arriving: list[tuple[float, Any]] = []
        self._ear, self._mouth = MavlinkCodec(0, 0), MavlinkCodec(1, 191)

    @property
    def made(self) -> int:
        return self.camera.images - BEFORE

    def tick(self) -> None:
        self.now_s = round(self.now_s + TICK_S, 3)
        moment = Moment(self.now_s, self.now_s, is_quiet=False)
        self.cameras.step(moment)
        due = [m for at_s, m in self._arriving if at_s <= self.now_s]
        self._arriving = [each for each in self._arriving if each[0] > self.now_s]
        for message in due:
            self.cameras.take(moment, message)
        state = REST._replace(time_s=self.now_s)
        for command in self.cameras.due(moment):
            self._hear(command, state)
        for packed in self.component.step(state):
            self._say(packed)

    def _hear(self, command: Any, state: FlightState) -> None:
        command.target_system = 1  # nobody has said which one it is
        if command.command == SHOOT:
            self.sent += 1
            if self.sent == 1 and self.world.asked is Fate.LOST:
                return
            if self.camera.is_shooting and not self.world.tells_work:
                self.taken += 1  # it makes another one afterwards, and does not say so
                return
            self.taken += not self.camera.is_shooting
        (heard,) = self._ear.parse(self._mouth.pack(command))
        for packed in self.component.receive(heard, state):
            self._say(packed)

    def _say(self, packed: Any) -> None:
        (message,) = self._ear.parse(packed[1])
        world, fate = self.world, Fate.COMES
        match message.get_type():
            case "COMMAND_ACK" if message.command == SHOOT:
                is_progress = message.result == MavResult.IN_PROGRESS
                fate = Fate.LOST if is_progress and not world.is_told else world.answer
            case "CAMERA_IMAGE_CAPTURED":
                fate = world.image
            case "CAMERA_CAPTURE_STATUS":
                is_begun = self.sent > 0
                fate = Fate.COMES if world.is_status_answered or not is_begun else Fate.LOST
                if not world.tells_work:
                    message.image_status = 0
        if fate is not Fate.LOST:
            late_s = world.late_s if fate is Fate.LATE else 0.0
            self._arriving.append((self.now_s + late_s, message))

    def call(self) -> PhotoMade | Failed:
        """One try of a skill."""
        world, limit_s = self.world, self.world.timeout_s or PHOTO_S
        ticket = self.cameras.prepare(CAMERA, OWNER, world.timeout_s, world.may_repeat)
        begun_s = self.now_s
        while True:
            self.tick()
            match self.cameras.outcome(ticket):
                case ShotReady():
                    self.cameras.shoot(ticket)
                case PhotoMade() | Failed() as outcome:
                    self.cameras.forget(ticket)
                    assert self.now_s - begun_s <= limit_s + 3 * TICK_S
                    return outcome
            assert self.now_s - begun_s <= limit_s + 3 * TICK_S, "it has not ended in its time"

    def run(self, seconds: float) -> None:
        for _ in range(math.ceil(seconds / TICK_S)):
            self.tick()


def tried(world: World, tries: int) -> None:
    """A skill that is tried until there is a photo, and what has to be so."""
    meeting = Meeting(world)
    meeting.run(1.0)
    for _ in range(tries):
        before = meeting.sent
        outcome = meeting.call()
        if not (world.may_repeat or world.tells_work):
            assert meeting.sent - before <= 1, "asked for again in one call"
        if isinstance(outcome, PhotoMade):
            assert meeting.made >= 1, f"done without a photo: {outcome}"
            assert outcome.number == BEFORE + 1
            break
        assert outcome.reason
    meeting.run(world.after_s + world.late_s)
    if not world.may_repeat and not world.fails:
        assert meeting.made <= 1 and meeting.taken <= 1, "two photos of one skill"


def test_without_losses_it_is_made_at_once() -> None:
    world = World(Fate.COMES, Fate.COMES, Fate.COMES, True, True, True, False, 0.5, 0.0)
    meeting = Meeting(world)
    assert meeting.call() == PhotoMade(BEFORE + 1, BEFORE)
    assert (meeting.sent, meeting.made) == (1, 1) and meeting.now_s < 2.0


LATE_S, AFTER_S = st.floats(0.3, 12.0), st.floats(0.1, PHOTO_S - 1.0)


@drawn(60)
@given(
    st.builds(
        World,
        st.sampled_from([Fate.COMES, Fate.LOST]),
        *[st.sampled_from(Fate)] * 2,
        *[st.booleans()] * 4,
        AFTER_S,
        LATE_S,
        st.none() | st.floats(1.0, 20.0),
        st.booleans(),
    ),
    st.integers(1, 3),
)
def test_whatever_is_lost_or_late_there_is_one_photo_and_no_word_too_many(
    world: World, tries: int
) -> None:
    tried(world, tries)


def every() -> Iterator[World]:
    fates = product((Fate.COMES, Fate.LOST), Fate, Fate)
    flags = product(*[(False, True)] * 4)
    for (asked, answer, image), (a, b, c, d) in product(fates, flags):
        for after_s, late_s in ((0.4, 1.0), (5.0, 3.0), (9.0, 8.0), (14.0, 12.0)):
            yield World(asked, answer, image, a, b, c, d, after_s, late_s)


@pytest.mark.long
@pytest.mark.parametrize("timeout_s", [None, 4.0, 10.0])
def test_so_it_is_in_every_combination(timeout_s: float | None) -> None:
    for world in every():
        tried(replace(world, timeout_s=timeout_s), tries=3)


@pytest.mark.parametrize("after_s", [20.0, 60.0])
def test_a_call_asks_once_however_long_the_camera_takes(after_s: float) -> None:
    tried(World(Fate.COMES, Fate.LOST, Fate.LOST, True, False, False, False, after_s, 0.0), 1)
