"""What is known of one camera: whether it is there, what it has counted, what it may still make.

Many cameras do not say that they are at work, and some need seconds for a photo. So a photo that
was asked for, and of which nothing was heard, may still be made, for as long as one may take; but
not by a camera that was heard before to say when it is at work, and says that it is idle.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass, field

from companion.mavlink.framing import Message
from companion.vehicle.camera_port import ShotOwner

ONLINE_S = 3.0
"""So long after anything was heard of it a camera is there; a heartbeat comes each second."""
RESEND_S = 2.0
"""A camera that says when it is at work, and is idle then, has not heard what it was asked."""
KEPT_INDICES, KEPT_MARKS = 1000, 100


@dataclass
class Mark:
    """A photo that was, or may have been, asked for.

    Attributes:
        image_count: what the camera had counted before.
        sent_s: when that was, at the latest.
        until_s: so long it may still be made.
    """

    image_count: int
    sent_s: float
    until_s: float


@dataclass
class KnownCamera:
    """What is known of one camera.

    Attributes:
        heard_s: when anything was heard of it.
        image_count: of its newest status, None before the first one.
        is_idle: by that status.
        tells_work: a status has said that it is at work, while it made a photo of ours.
        open: a photo that was asked for, and of which nothing is known; None without one.
        status_s: when it was heard; never, where an image has come since.
        sequence: the greatest number that a photo was asked for with.
        marks: photos by what they are for.
        indices: of its newest images.
    """

    component: int
    heard_s: float = -math.inf
    image_count: int | None = None
    is_idle: bool = True
    tells_work: bool = False
    open: Mark | None = None
    status_s: float = -math.inf
    sequence: int = 0
    marks: dict[ShotOwner, Mark] = field(default_factory=dict)
    indices: deque[int] = field(default_factory=lambda: deque(maxlen=KEPT_INDICES))

    def absence(self, now_s: float) -> str | None:
        """That it is not there, in words; None if it is."""
        if now_s - self.heard_s <= ONLINE_S:
            return None
        silent = f"for {now_s - self.heard_s:.0f} s" if self.heard_s > -math.inf else "yet"
        return f"the camera (component {self.component}) is offline: nothing heard {silent}"

    def mark(self, owner: ShotOwner, image_count: int, now_s: float, longest_s: float) -> None:
        """A photo is, or may have been, asked for, which may take so long.

        What others have asked for was not made, where the count has not risen since.
        """
        self.marks = {
            other: mark
            for other, mark in self.marks.items()
            if other != owner and mark.image_count < image_count
        }
        self.marks[owner] = self.open = Mark(image_count, now_s, now_s + longest_s)
        if len(self.marks) > KEPT_MARKS:
            del self.marks[next(iter(self.marks))]

    def settle(self) -> None:
        """What was asked for was made, or is not made any more."""
        self.open = None

    def take_image(self, index: int, is_good: bool) -> None:
        """An image is there, or has failed, whoever has asked for it."""
        if self.open is not None and (not is_good or index >= self.open.image_count):
            self.settle()
        if is_good:
            self.indices.append(index)
            self.status_s = -math.inf  # its count is older than this image

    def take_status(self, now_s: float, message: Message) -> None:
        """Takes a CAMERA_CAPTURE_STATUS."""
        self.image_count, self.status_s = message.image_count, now_s
        self.is_idle = message.image_status in (0, 2)  # idle, or between two of a series
        if self.open is not None:
            self.tells_work |= not self.is_idle
            if self.image_count > self.open.image_count:
                self.settle()

    def may_be_asked(self, may_repeat: bool) -> bool:
        """Whether the newest status says that no photo is under way; rules 4 and 5."""
        if self.open is None or not self.is_idle:
            return self.is_idle
        is_told = self.tells_work or may_repeat
        since_s = self.open.sent_s + RESEND_S if is_told else self.open.until_s
        return self.status_s >= since_s
