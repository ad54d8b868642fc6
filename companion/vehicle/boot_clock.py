"""When something was measured, by our clock, from the autopilot's time since boot.

A link that buffers hands on old positions as if they were new. The autopilot stamps them with its
own clock, and tells by TIMESYNC what that clock shows. It showed `tc1` after our question was sent,
so what is stamped `tc1` was measured no earlier than that. This bound is taken: nothing is taken
for newer than it is, nor for older by more than the question took on its way. Of the answers of
WINDOW_S the one with the latest bound counts: its question was the quickest. A clock that falls
behind ours, as a simulated autopilot's does on a busy machine, has it in the newest answer.

Rules:
1. A question a second until FEW are answered, then one in RELAXED_S; a clock that runs at another
   rate than ours is asked each second, as its rate may change.
2. An answer counts if it echoes a question of ours, once.
3. A stamp, or an answer, that steps back by more than BACK_S is of a clock that has begun anew: the
   answers of before count no longer.
4. Without an answer what was measured was measured when it arrived.

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
"""Two clocks that differ by 100 millionths drift by 3 ms in it."""
FEW = 5
BACK_S = 1.0
NANO = 1_000_000_000


class ClockOffset(NamedTuple):
    """What one clock shows beside another.

    Attributes:
        offset_s: what ours shows when the other shows 0.
        uncertainty_s: the most that this is wrong by.
    """

    offset_s: float
    uncertainty_s: float


def told_boot_s(datagrams: Iterable[bytes], system: int) -> float | None:
    """What a system's autopilot stamps its position with, in seconds; None if it tells none."""
    codec = MavlinkCodec(0, 0)
    for message in (message for datagram in datagrams for message in codec.parse(datagram)):
        is_theirs = source(message) == (system, dialect.MAV_COMP_ID_AUTOPILOT1)
        if is_theirs and message.get_type() == "LOCAL_POSITION_NED":
            return float(message.time_boot_ms) / 1000
    return None


class BootClock:
    """The clock of one autopilot, as seen from here.

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
        self._bound_s: float | None = None  # the latest of theirs: what ours showed at a 0 of its

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
        """Takes a TIMESYNC of the autopilot; questions of its own are passed."""
        if message.tc1 <= 0 or (asked_s := self._asked.pop(message.ts1, None)) is None:
            return
        boot_s = message.tc1 / NANO
        self._follow(boot_s)
        self._forget(now_s)
        answer = ClockAnswer(asked_s, now_s, boot_s)
        self._answers.append(answer)
        if self.rate.take(answer):
            self._answers = self._answers[-1:]  # ours goes at another rate from now on
        self._find_bound()

    def measured_s(self, now_s: float, boot_s: float) -> float:
        """When something was measured, by our clock; now at the latest.

        Args:
            now_s: when it arrived.
            boot_s: its stamp, seconds since the autopilot's boot.
        """
        self._follow(boot_s)
        return now_s if self._bound_s is None else min(now_s, boot_s + self._bound_s)

    @property
    def offset(self) -> ClockOffset | None:
        """Our clock beside the autopilot's; None before it has answered.

        It has read its clock while the question was on its way, there or back.
        """
        if not self._answers:
            return None
        quickest = min(self._answers, key=lambda answer: answer.round_trip_s)
        uncertainty_s = quickest.round_trip_s / 2
        return ClockOffset(quickest.asked_s + uncertainty_s - quickest.boot_s, uncertainty_s)

    def _follow(self, boot_s: float) -> None:
        """Takes the autopilot's time; one that steps back is that of another boot."""
        if boot_s < self._newest_s - BACK_S:
            self._answers.clear()
            self._find_bound()
            self._newest_s = boot_s
        self._newest_s = max(self._newest_s, boot_s)

    def _forget(self, now_s: float) -> None:
        """What is older than the window counts no longer; the newest answer does until the next."""
        recent = [answer for answer in self._answers if now_s - answer.asked_s <= WINDOW_S]
        self._answers = recent or self._answers[-1:]
        asked = self._asked.items()
        self._asked = {key: asked_s for key, asked_s in asked if now_s - asked_s <= WINDOW_S}
        self._find_bound()

    def _find_bound(self) -> None:
        bounds_s = (each.asked_s - each.boot_s for each in self._answers)
        self._bound_s = max(bounds_s, default=None)
