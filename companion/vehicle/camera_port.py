"""What the acting side knows of cameras: a photo is prepared, then shot, then made or not.

Between the two the acting side writes down what is intended, so that another process can ask the
camera what has become of it. `cameras.py` fulfils the port over MAVLink.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol


@dataclass(frozen=True, slots=True)
class ShotReady:
    """The camera is there, idle, and has said how many photos it has made; it may be asked now.

    Attributes:
        sequence: number that the photo is asked for with; no other has had it in the run.
        image_count: what the camera has counted before it.
    """

    sequence: int
    image_count: int


@dataclass(frozen=True, slots=True)
class PhotoMade:
    """The photo is there.

    Attributes:
        number: of the photo, as the camera counts them, from 1.
        image_index: of the camera; None where the message that tells it was lost.
    """

    number: int
    image_index: int | None


@dataclass(frozen=True, slots=True)
class NoPhoto:
    """There is none, or that is not known, for a reason in words."""

    reason: str


ShotOutcome = ShotReady | PhotoMade | NoPhoto | None
"""What has become of a photo; None while it is on its way."""


ShotOwner = tuple[str, int, int]
"""What a photo is for: an action, at a position of the word, and which of its steps."""


@dataclass(frozen=True, slots=True)
class IntendedShot:
    """A photo that is about to be asked for.

    Attributes:
        component: the camera.
        action: that it is for.
        position: of the word, at which the action is done.
        nth: of the action's steps, from 0.
        sequence: that it is asked for with.
        image_count: what the camera has counted before it.
    """

    component: int
    action: str
    position: int
    nth: int
    sequence: int
    image_count: int

    @property
    def owner(self) -> ShotOwner:
        """What it is for."""
        return (self.action, self.position, self.nth)


class Cameras(Protocol):
    """The cameras of a vehicle."""

    def prepare(
        self,
        component: int,
        owner: ShotOwner,
        timeout_s: float | None,
        may_repeat: bool = False,
    ) -> int:
        """Begin with a photo; returns a ticket for the other methods.

        Args:
            component: the camera.
            owner: what the photo is for; it is made once for each owner.
            timeout_s: time for all of it; None for the usual one.
            may_repeat: a second photo does no harm, where the answer to the first may be lost.
        """

    def shoot(self, ticket: int) -> None:
        """Ask for the photo, which is ready."""

    def outcome(self, ticket: int) -> ShotOutcome:
        """What has become of it."""

    def forget(self, ticket: int) -> None:
        """Ask for it no longer; what was asked for may still be made."""

    def recall(self, shot: IntendedShot) -> None:
        """Another process was about to ask for this photo; whether it was made is not known."""
