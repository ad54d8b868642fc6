"""A camera on board by the camera protocol, version 2: its answers to commands and its images.

Its order is that of MAVSDK 4.1's camera server: IN_PROGRESS at once, ACCEPTED after the shot, then
the image. A command with an equal sequence number asks for a second photo if the first is done.

1. While the camera shoots or is busy, it answers another photo with TEMPORARILY_REJECTED.
2. If its storage is full, it answers DENIED.
3. Where photos fail, the camera accepts the command, then reports a failed image and does not count
   it.

    state      a photo is asked for        its time is over
    idle       shooting, or rules 1, 2
    shooting   rule 1                      idle; the image exists, or rule 3
"""

from __future__ import annotations

from dataclasses import dataclass
from random import Random

from companion.geometry import Ned
from sitl.results import MavResult
from sitl.world.payload import CommandAck, Requester
from sitl.world.visits import Circle

SHOT_MIB = 4.0


@dataclass(frozen=True, slots=True)
class CameraSpec:
    """The properties of a camera.

    Attributes:
        after_s: how long a photo takes.
        images: how many it has taken before the start.
        capacity: how many more its storage can hold.
        fails: circles in which its photos fail.
        lost: share of its image messages that it never sends.
    """

    component: int
    after_s: float = 0.5
    images: int = 0
    capacity: int = 1000
    fails: tuple[Circle, ...] = ()
    lost: float = 0.0


@dataclass(frozen=True, slots=True)
class CameraChange:
    """A change of a camera; None leaves a property as it is.

    Attributes:
        component: id of the camera; None is the first one.
        is_silent: it sends nothing and receives nothing.
    """

    component: int | None = None
    after_s: float | None = None
    is_busy: bool | None = None
    fails: bool | None = None
    is_full: bool | None = None
    is_silent: bool | None = None
    lost: float | None = None


@dataclass(frozen=True, slots=True)
class Image:
    """A photo that was taken or has failed.

    Attributes:
        index: from 0.
        is_lost: the camera never reports it.
    """

    index: int
    is_good: bool
    is_lost: bool


@dataclass(frozen=True, slots=True)
class _Shooting:
    requester: Requester
    end_s: float


class Camera:
    """One camera.

    Args:
        spec: its properties.
        rng: decides which messages are lost.

    Attributes:
        images: how many it has taken.
        is_silent: it sends nothing.
    """

    def __init__(self, spec: CameraSpec, rng: Random) -> None:
        self.spec = spec
        self.images = spec.images
        self.is_silent = False
        self._rng = rng
        self._after_s, self._lost = spec.after_s, spec.lost
        self._is_busy = self._fails = self._is_full = False
        self._shooting: _Shooting | None = None

    @property
    def is_shooting(self) -> bool:
        """Whether a photo is under way, whoever asked for it."""
        return self._shooting is not None or self._is_busy

    @property
    def left(self) -> int:
        """How many more photos its storage can hold."""
        made = self.images - self.spec.images
        return 0 if self._is_full else max(0, self.spec.capacity - made)

    def change(self, change: CameraChange) -> None:
        """Applies a change of the scenario."""
        if change.after_s is not None:
            self._after_s = change.after_s
        if change.is_busy is not None:
            self._is_busy = change.is_busy
        if change.fails is not None:
            self._fails = change.fails
        if change.is_full is not None:
            self._is_full = change.is_full
        if change.is_silent is not None:
            self.is_silent = change.is_silent
        if change.lost is not None:
            self._lost = change.lost

    def shoot(self, requester: Requester, count: float, now_s: float) -> CommandAck:
        """The answer to MAV_CMD_IMAGE_START_CAPTURE."""
        if self.is_shooting:
            return CommandAck(requester, MavResult.TEMPORARILY_REJECTED)
        if count != 1 or not self.left:
            return CommandAck(requester, MavResult.DENIED)
        self._shooting = _Shooting(requester, now_s + self._after_s)
        return CommandAck(requester, MavResult.IN_PROGRESS, progress=255)

    def step(self, position: Ned, now_s: float) -> tuple[CommandAck, Image] | None:
        """The photo that is done now, with the answer to its command."""
        shooting = self._shooting
        if shooting is None or now_s < shooting.end_s:
            return None
        self._shooting = None
        is_good = not self._fails and not any(c.contains(position) for c in self.spec.fails)
        index = self.images
        self.images += is_good
        image = Image(index, is_good, self._rng.random() < self._lost)
        return CommandAck(shooting.requester, MavResult.ACCEPTED), image
