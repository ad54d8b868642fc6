"""What is known of one camera: its presence, its count of photos, what it may still make.

Many cameras do not say when they are at work, and some need seconds for a photo. So a photo that
was asked for, and of which nothing was heard, may still be made for as long as one may take. The
exception is a camera that has shown before that it says when it is at work, and says that it is
idle.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass, field

from companion.mavlink.framing import Message
from companion.vehicle.ports.cameras import ShotOwner

ONLINE_S = 3.0
"""A camera counts as present this long after its last message; a heartbeat comes each second."""
RESEND_S = 2.0
"""If a camera that says when it is at work is idle after this time, it did not get the request."""
KEPT_INDICES, KEPT_MARKS = 1000, 100


@dataclass
class Mark:
    """A photo that was, or may have been, asked for.

    Attributes:
        image_count: the camera's count before it.
        sent_s: when it was asked for, at the latest.
        until_s: until when it may still be made.
    """

    image_count: int
    sent_s: float
    until_s: float


@dataclass
class KnownCamera:
    """What is known of one camera.

    Attributes:
        heard_s: when its last message was heard.
        image_count: count in its newest status; None before the first one.
        is_idle: whether it is idle by that status.
        tells_work: a status has said that it is at work, while it made a photo of ours.
        open: a photo that was asked for, with unknown result; None without one.
        status_s: when the status was heard; -inf if an image has come since.
        sequence: greatest number with which a photo was asked for.
        marks: photos, by what they are for.
        indices: those of its newest images.
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
        """A sentence if the camera is not present; None if it is."""
        if now_s - self.heard_s <= ONLINE_S:
            return None
        silent = f"for {now_s - self.heard_s:.0f} s" if self.heard_s > -math.inf else "yet"
        return f"the camera (component {self.component}) is offline: nothing heard {silent}"

    def mark(self, owner: ShotOwner, image_count: int, now_s: float, longest_s: float) -> None:
        """Notes that a photo is, or may have been, asked for, which takes `longest_s` at most.

        Marks of other photos are dropped if the count has not risen since: these were not made.
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
        """The result of the open photo is known."""
        self.open = None

    def take_image(self, index: int, is_good: bool) -> None:
        """Takes note that an image was captured or has failed, whoever asked for it."""
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
        """Whether the newest status shows that no photo is under way; rules 4 and 5 of
        `photo_shot.py`.
        """
        if self.open is None or not self.is_idle:
            return self.is_idle
        is_told = self.tells_work or may_repeat
        since_s = self.open.sent_s + RESEND_S if is_told else self.open.until_s
        return self.status_s >= since_s
