"""The companion's HEARTBEAT: once a second, when the status changes, and when it is requested."""

from __future__ import annotations

from companion.ground import about
from companion.ground.operations import SystemStatus
from companion.mavlink.framing import Message

HEARTBEAT_S = 1.0


class CompanionHeartbeat:
    """When a HEARTBEAT is due."""

    def __init__(self) -> None:
        self._sent: SystemStatus | None = None
        self._next_s = 0.0

    def request(self) -> None:
        """Makes the next one due at once."""
        self._sent = None

    def due(self, now_s: float, status: SystemStatus) -> list[Message]:
        """The HEARTBEAT to send now; [] if none is due."""
        if now_s < self._next_s and status is self._sent:
            return []
        self._next_s, self._sent = now_s + HEARTBEAT_S, status
        return [about.heartbeat(status)]
