"""Converts the autopilot's time stamps (time since boot) to the companion's clock.

A link that buffers may deliver old positions as if they were new. The autopilot stamps positions
with its own clock, and TIMESYNC tells what that clock shows. If the autopilot's answer says `tc1`,
its clock showed `tc1` after the question was sent; so a position stamped `tc1` was measured no
earlier than the question. This lower bound is used as the time of measurement: it is never too
late, and too early by at most the time that the question was under way. Among the answers of the
last WINDOW_S the latest bound is used, as it comes from the question that was quickest. If the
other clock runs slow, as that of a simulated autopilot on a busy machine, the newest answer has the
latest bound.

Rules:
1. One question a second until FEW are answered, then one in RELAXED_S. A clock whose rate differs
   from ours is asked every second, as its rate may change again.
2. An answer counts only if it echoes one of our questions, and only once.
3. A stamp or an answer that steps back by more than BACK_S means that the clock has started anew.
   Earlier answers are discarded.
4. Before the first answer, the time of arrival is taken as the time of measurement.

Source: https://mavlink.io/en/services/timesync.html; PX4 v1.16 answers `tc1` = 0 with its clock.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import NamedTuple

from companion.mavlink.framing import MavlinkCodec, Message, dialect, source
from companion.vehicle.clock_rate import ClockAnswer, ClockRate

QUESTION_S, RELAXED_S = 1.0, 5.0
WINDOW_S = 30.0
"""Two clocks whose rates differ by 100 parts per million drift apart by 3 ms in this time."""
FEW = 5
BACK_S = 1.0
NANO = 1_000_000_000


class ClockOffset(NamedTuple):
    """How another clock compares with ours.

    Attributes:
        offset_s: what our clock showed when the other one showed 0.
        uncertainty_s: greatest error of the offset.
    """

    offset_s: float
    uncertainty_s: float


def told_boot_s(datagrams: Iterable[bytes], system: int) -> float | None:
    """Seconds since boot in the autopilot's LOCAL_POSITION_NED; None if there is no such
    message."""
    codec = MavlinkCodec(0, 0)
    for message in (message for datagram in datagrams for message in codec.parse(datagram)):
        is_theirs = source(message) == (system, dialect.MAV_COMP_ID_AUTOPILOT1)
        if is_theirs and message.get_type() == "LOCAL_POSITION_NED":
            return float(message.time_boot_ms) / 1000
    return None


class BootClock:
    """The clock of one autopilot, compared with ours.

    Attributes:
        rate: how fast it runs.

    >>> clock = BootClock()
    >>> (question,) = clock.due(100.0)
    >>> clock.take(100.1, dialect.MAVLink_timesync_message(7 * NANO, question.ts1))
    >>> clock.measured_s(110.0, 16.5)
    109.5
    """

    def __init__(self) -> None:
        self.rate = ClockRate()
        self._next_s = -math.inf
        self._newest_s = -math.inf
        self._asked: dict[int, float] = {}
        self._answers: list[ClockAnswer] = []
        self._bound_s: float | None = None  # ours when theirs showed 0: the latest lower bound

    def due(self, now_s: float) -> list[Message]:
        """The question to send now, if any."""
        if now_s < self._next_s:
            return []
        self._forget(now_s)
        is_relaxed = len(self._answers) >= FEW and not self.rate.has_differed
        self._next_s = now_s + (RELAXED_S if is_relaxed else QUESTION_S)
        nanoseconds = round(now_s * NANO)
        self._asked[nanoseconds] = now_s
        return [dialect.MAVLink_timesync_message(0, nanoseconds)]

    def take(self, now_s: float, message: Message) -> None:
        """Takes a TIMESYNC of the autopilot; its own questions are ignored."""
        if message.tc1 <= 0 or (asked_s := self._asked.pop(message.ts1, None)) is None:
            return
        boot_s = message.tc1 / NANO
        self._follow(boot_s)
        self._forget(now_s)
        answer = ClockAnswer(asked_s, now_s, boot_s)
        self._answers.append(answer)
        if self.rate.take(answer):
            self._answers = self._answers[-1:]  # our clock changes its rate now
        self._find_bound()

    def measured_s(self, now_s: float, boot_s: float) -> float:
        """When something was measured, by our clock; never later than now.

        Args:
            now_s: when it arrived.
            boot_s: its stamp: seconds since the autopilot's boot.
        """
        self._follow(boot_s)
        return now_s if self._bound_s is None else min(now_s, boot_s + self._bound_s)

    @property
    def offset(self) -> ClockOffset | None:
        """The offset to the autopilot's clock; None before it has answered.

        It assumes that the autopilot read its clock halfway between question and answer.
        """
        if not self._answers:
            return None
        quickest = min(self._answers, key=lambda answer: answer.round_trip_s)
        uncertainty_s = quickest.round_trip_s / 2
        return ClockOffset(quickest.asked_s + uncertainty_s - quickest.boot_s, uncertainty_s)

    def _follow(self, boot_s: float) -> None:
        """Takes a time of the autopilot; one that steps back belongs to another boot."""
        if boot_s < self._newest_s - BACK_S:
            self._answers.clear()
            self._find_bound()
            self._newest_s = boot_s
        self._newest_s = max(self._newest_s, boot_s)

    def _forget(self, now_s: float) -> None:
        """Drops what is older than the window, but keeps the newest answer until the next one."""
        recent = [answer for answer in self._answers if now_s - answer.asked_s <= WINDOW_S]
        self._answers = recent or self._answers[-1:]
        asked = self._asked.items()
        self._asked = {key: asked_s for key, asked_s in asked if now_s - asked_s <= WINDOW_S}
        self._find_bound()

    def _find_bound(self) -> None:
        bounds_s = (each.asked_s - each.boot_s for each in self._answers)
        self._bound_s = max(bounds_s, default=None)
