"""Learns the network address of the autopilot, to which the companion sends its answers.

Any program can send to a port, so an address has to be earned. The rules:

1. An address is learned only from an autopilot's HEARTBEAT whose checksum is right.
2. The first autopilot heard decides the system id; heartbeats of other systems are ignored.
3. An address is kept while heartbeats come from it. Another address replaces it only after
   `SILENT_S` without one, as after a restart of the autopilot on another port.

Source: https://mavlink.io/en/services/heartbeat.html. No I/O.
"""

from __future__ import annotations

import logging

from companion.mavlink.framing import choose, dialect, message_of, source
from companion.mavlink.intake import Address
from companion.vehicle.wire import is_autopilot

SILENT_S = 3.0
"""Three heartbeats were missed: the autopilot is no longer at its address."""

_HEARTBEAT = frozenset({dialect.MAVLINK_MSG_ID_HEARTBEAT})

log = logging.getLogger(__name__)


class AutopilotAddress:
    """Learns where the autopilot is.

    Attributes:
        system: the autopilot's system id; None until it was heard.
        address: the autopilot's address; None until it was heard.
    """

    def __init__(self) -> None:
        self.system: int | None = None
        self.address: Address | None = None
        self._heard_s = 0.0

    def hear(self, now_s: float, sender: Address, datagram: bytes) -> None:
        """Takes a datagram into account.

        Args:
            now_s: wall-clock time at which it arrived, from any zero.
            sender: where it came from.
            datagram: its bytes.
        """
        for frame in choose([datagram], _HEARTBEAT, frozenset()):
            message = message_of(frame)
            if is_autopilot(message):
                self._learn(now_s, sender, source(message)[0])

    def _learn(self, now_s: float, sender: Address, system: int) -> None:
        if self.system is None:
            self.system = system
        if system != self.system:
            return
        if self.address in (None, sender) or now_s - self._heard_s > SILENT_S:
            if self.address != sender:
                log.debug("answers go to %s:%d, the autopilot of system %d", *sender, system)
            self.address, self._heard_s = sender, now_s
