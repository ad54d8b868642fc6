"""Sends events to ground stations as STATUSTEXT, at a rate that a radio link can carry.

Each event meant for people becomes one text; a text longer than a message is split into chunks with
a common id. Several texts of one moment (a failure, a belief, a plan) would be a burst, so they
wait in a queue. A text that has waited too long is dropped unless it is a warning or worse, so that
people read only what is recent.
"""

from __future__ import annotations

import math
from collections import deque

from companion.errors import printable
from companion.flight_events.event import FlightEvent
from companion.flight_events.facts import (
    BeliefRestored,
    BeliefWithdrawn,
    MissionEventChanged,
    PlaceLost,
)
from companion.flight_events.frames import FrameDoubted, OriginMoved
from companion.flight_events.hosting import (
    ClockFollowed,
    DatagramsDropped,
    FramesRefused,
    PortLost,
    RecordingFailed,
    UploadNews,
)
from companion.flight_events.plans import LineDropped, LineTakenUp, NoPlanFound, PlanReplaced
from companion.flight_events.reports import (
    ReportRefused,
    ReportUnknown,
    SignalOfAnother,
    SignalSilent,
)
from companion.flight_events.skills import (
    LowPlacesFlown,
    OutcomeUnknown,
    PlaceFunctionFailed,
    SkillFailed,
    WrittenTreeFailed,
)
from companion.flight_events.sortie import (
    AutopilotSaid,
    ControlTakenBack,
    FlightFoundAgain,
    GoalFailed,
    LinkSilent,
    RunEnded,
    RunFailed,
    SetpointRefused,
    VehicleCrashed,
)
from companion.flight_events.word import ConjunctViolated, ViolatedBefore
from companion.mavlink.framing import Message, dialect
from companion.mavlink.statustext import chunks

MESSAGE_S = 0.1
"""Time between two messages: 650 bytes a second, a tenth of a radio of 57600 baud."""
PATIENCE_S = 5.0
LONGEST = 196
"""Bytes of a text: four messages. Plans may be longer; the run folder has them in full."""

CRITICAL: int = dialect.MAV_SEVERITY_CRITICAL
ERROR: int = dialect.MAV_SEVERITY_ERROR
WARNING: int = dialect.MAV_SEVERITY_WARNING
NOTICE: int = dialect.MAV_SEVERITY_NOTICE
INFO: int = dialect.MAV_SEVERITY_INFO
DEBUG: int = dialect.MAV_SEVERITY_DEBUG


def severity(event: FlightEvent) -> int:
    """Returns the MAV_SEVERITY of an event."""
    match event:
        case RunFailed() | VehicleCrashed():
            return CRITICAL
        case ConjunctViolated(optional=False) | RecordingFailed():
            return ERROR
        case SkillFailed() | WrittenTreeFailed() | BeliefWithdrawn() | SetpointRefused():
            return WARNING
        case GoalFailed() | OutcomeUnknown() | LinkSilent() | PlaceFunctionFailed():
            return WARNING
        case FlightFoundAgain() | ControlTakenBack() | FrameDoubted() | OriginMoved():
            return WARNING
        case PlaceLost() | LineDropped() | ConjunctViolated() | ViolatedBefore():
            return WARNING
        case UploadNews(is_refused=True) | FramesRefused() | PortLost() | SignalSilent():
            return WARNING
        case ReportRefused() | ReportUnknown() | SignalOfAnother() | DatagramsDropped():
            return WARNING
        case LowPlacesFlown() | ClockFollowed():
            return WARNING
        case MissionEventChanged() | BeliefRestored() | UploadNews() | RunEnded():
            return NOTICE
        case PlanReplaced() | NoPlanFound() | LineTakenUp():
            return NOTICE
        case AutopilotSaid():
            return DEBUG  # ground stations hear it from the autopilot itself
    return INFO


class StatusTextQueue:
    """The queue of texts.

    Attributes:
        level: the greatest MAV_SEVERITY number that is sent; 7 sends all.
    """

    def __init__(self) -> None:
        self.level = INFO
        self._queue: deque[tuple[float, int, list[Message]]] = deque()
        self._number = 0
        self._next_s = 0.0

    def tell(self, now_s: float, severity: int, text: str) -> None:
        """Queues a text of any length and any number of lines."""
        if severity <= self.level:
            self._put(now_s, severity, text)

    def mark(self, text: str) -> None:
        """Queues a text by which logs are found: it is sent at any level, and however late."""
        self._put(math.inf, NOTICE, text)

    def _put(self, since_s: float, severity: int, text: str) -> None:
        one_line = "; ".join(line.strip() for line in printable(text).splitlines() if line.strip())
        raw = one_line.encode()
        if len(raw) > LONGEST:
            one_line = raw[: LONGEST - 3].decode(errors="ignore") + "..."
        self._number += 1
        self._queue.append((since_s, severity, chunks(severity, one_line, self._number)))

    def due(self, now_s: float) -> list[Message]:
        """Returns the message to send now, if any."""
        if not self._queue or now_s < self._next_s:
            return []
        self._next_s = now_s + MESSAGE_S
        self._leave_out(now_s)
        if not self._queue:
            return []
        _, _, messages = self._queue[0]
        first = messages.pop(0)
        if not messages:
            self._queue.popleft()
        return [first]

    def rest(self) -> list[Message]:
        """Returns all messages that are left, at the end of a run."""
        left = [m for _, _, messages in self._queue for m in messages]
        self._queue.clear()
        return left

    def _leave_out(self, now_s: float) -> None:
        """Drops texts that have waited too long, unless a part of them was sent."""
        while self._queue:
            since_s, severity, messages = self._queue[0]
            is_begun = getattr(messages[0], "chunk_seq", 0) > 0
            if is_begun or severity <= WARNING or now_s - since_s <= PATIENCE_S:
                return
            self._queue.popleft()
