"""Answers the autopilot's questions for the time, so that its log relates its clock to ours.

On a link to a companion PX4 asks by TIMESYNC ten times a second (`tc1` = 0). From the answers it
computes the offset between the clocks, writes it into its log (`timesync_status`), and reads our
time stamps with it. The answers come from one clock that never steps back: the machine's monotonic
clock (CLOCK_MONOTONIC), which other programs on board read as well; in lockstep, the time of the
flight.

Rules:
1. Only the vehicle's own autopilot is answered, not other components or other systems' autopilots.
2. PX4 rejects an answer that takes 10 ms or more. So a question is answered when it arrives
   (`driving.py`), not in the next tick. Each question gets one answer.
3. At most one answer in LEAST_S, whatever arrives, so that a flood does not cause another.
4. An answer commands nothing. It is given in every phase, whoever flies.

Source: https://mavlink.io/en/services/timesync.html; PX4 v1.16 as observed. Our own questions, and
the answers to them, belong to `boot_clock.py`.
"""

from __future__ import annotations

import math
from collections import deque

from companion.mavlink.framing import Message, dialect, source

LEAST_S = 0.02
"""Allows five times the rate at which PX4 asks."""
KEPT = 8
"""Questions remembered as answered: more than are answered within a tick. Each question is seen
once when it arrives, and again with all messages of the tick."""
NANO = 1_000_000_000
TIMESYNC = frozenset({dialect.MAVLINK_MSG_ID_TIMESYNC})


class TimeAnswers:
    """Answers the autopilot of one vehicle.

    >>> answers = TimeAnswers()
    >>> question = dialect.MAVLink_timesync_message(0, 77)  # its sender is not known: 0, 0
    >>> answers.answer(2.5, (0, 0), question).tc1
    2500000000
    >>> answers.answer(2.6, (0, 0), question) is None  # it has its answer
    True

    Attributes:
        zero_s: what the machine's clock showed when the flight's showed 0; None in lockstep.
    """

    def __init__(self) -> None:
        self.zero_s: float | None = None
        self._answered = deque[int](maxlen=KEPT)
        self._next_s = -math.inf

    def answer(self, now_s: float, autopilot: tuple[int, int], message: Message) -> Message | None:
        """The answer to a TIMESYNC; None if none is due.

        Args:
            now_s: the flight's time.
            autopilot: system and component id of the vehicle's autopilot.
            message: what was heard.
        """
        is_question = message.tc1 == 0 and source(message) == autopilot
        if not is_question or message.ts1 in self._answered or now_s < self._next_s:
            return None
        self._answered.append(message.ts1)
        self._next_s = now_s + LEAST_S
        shown = max(1, round(((self.zero_s or 0.0) + now_s) * NANO))  # 0 would be a question
        return dialect.MAVLink_timesync_message(shown, message.ts1)
