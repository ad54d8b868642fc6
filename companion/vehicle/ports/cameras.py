"""The acting side's interface to cameras: prepare a photo, ask for it, learn whether it was made.

Between preparing and asking, the acting side records what it intends. If the process dies, another
one can then ask the camera what became of the photo. `cameras.py` implements the port over MAVLink.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from companion.outcomes import Failed


@dataclass(frozen=True, slots=True)
class ShotReady:
    """The camera is present and idle, and its count of photos is known: the photo can be asked for.

    Attributes:
        sequence: number with which the photo is asked for; unique in the run.
        image_count: the camera's count before the photo.
    """

    sequence: int
    image_count: int


@dataclass(frozen=True, slots=True)
class PhotoMade:
    """The photo was made.

    Attributes:
        number: of the photo, as the camera counts them, from 1.
        image_index: the camera's own index; None if the message that carries it was lost.
    """

    number: int
    image_index: int | None


ShotOutcome = ShotReady | PhotoMade | Failed | None
"""What became of a photo; None while that is open."""


ShotOwner = tuple[str, int, int]
"""What a photo is for: an action, its position in the word, and the index of its step."""


@dataclass(frozen=True, slots=True)
class IntendedShot:
    """A photo that is about to be asked for.

    Attributes:
        component: the camera.
        action: the action that it is for.
        position: position of the word at which the action is done.
        nth: which of the action's steps, from 0.
        sequence: number with which it is asked for.
        image_count: the camera's count before it.
    """

    component: int
    action: str
    position: int
    nth: int
    sequence: int
    image_count: int

    @property
    def owner(self) -> ShotOwner:
        """What the photo is for."""
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
            owner: what the photo is for; each owner gets one photo.
            timeout_s: time for the whole procedure; None for the default.
            may_repeat: a second photo does no harm, should the answer to the first be lost.
        """

    def shoot(self, ticket: int) -> None:
        """Ask for a photo that is ready."""

    def outcome(self, ticket: int) -> ShotOutcome:
        """What became of the photo."""

    def forget(self, ticket: int) -> None:
        """Stop asking for the photo; it may still be made if it was asked for before."""

    def recall(self, shot: IntendedShot) -> None:
        """Another process was about to ask for this photo; it is not known whether it was made."""
