"""The door of the flight side: bytes to and from one vehicle. Everything else is a pure step.

`endpoints.py` says which links there are, `transport.py` carries the bytes. What is heard decides
who is answered: the autopilot that sends heartbeats (`autopilot_address.py`). Where the other end
is known beforehand, a heartbeat of the companion calls it once a second until it was heard: it may
wait to be spoken to.

From one `send` to the next is a step of the loop. What is received in it is bounded, whatever
arrives (`companion/mavlink/intake.py`); the address that is sent to has a share of its own. With a
key, frames are signed and verified here (`companion/mavlink/signing.py`), before anything is
learned from them.
"""

from __future__ import annotations

import logging
import math
import time

from companion.flight_events.event import FlightEvent
from companion.flight_events.hosting import DatagramsDropped, FramesRefused
from companion.mavlink.framing import MavlinkCodec, dialect
from companion.mavlink.intake import Address, Intake
from companion.mavlink.signing import Signing
from companion.vehicle.autopilot_address import AutopilotAddress
from companion.vehicle.endpoints import Endpoint
from companion.vehicle.transport import Transport, open_transport
from companion.vehicle.wire import COMPONENT

MAVLINK2_MAGIC = b"\xfd"
HOSTS_NAMED = 8
"""So many that were heard are named; a flood may come from any number."""
CALL_S = 1.0
CALLED_SYSTEM = 1
"""Whose companion calls, while the system is not known; PX4's default."""

log = logging.getLogger(__name__)


class Link:
    """Datagrams to and from one vehicle.

    Args:
        endpoint: our end of the link.
        signing: signs and verifies the frames; None for a link without signatures.
        calls: it is a companion's; what carries the words of others has none of its own.

    Raises:
        LinkError: the port cannot be opened.
    """

    def __init__(
        self, endpoint: Endpoint, signing: Signing | None = None, calls: bool = True
    ) -> None:
        self.endpoint = endpoint
        self._signing = signing
        self._begun_s = time.monotonic()
        self._hosts: set[str] = set()
        self._taken = self._mavlink = 0
        self._intake = Intake()
        self._autopilot = AutopilotAddress()
        self._caller = MavlinkCodec(CALLED_SYSTEM, COMPONENT)
        self._call_s = 0.0 if calls else math.inf
        self.transport: Transport = open_transport(endpoint)

    def receive(self) -> list[bytes]:
        """The datagrams that have arrived, as far as this step takes them in."""
        datagrams: list[bytes] = []
        for datagram, sender in self.transport.receive():
            if self._intake.takes(sender, datagram, self._peer):
                self._note(sender, datagram)
                for accepted in self._verified(datagram):
                    datagrams.append(accepted)
                    self._autopilot.hear(time.monotonic(), sender, accepted)
        return datagrams

    def discard(self) -> None:
        """Drops what has arrived so far, as it speaks of the past."""
        self.transport.discard()

    def send(self, datagrams: list[bytes]) -> None:
        """Sends to the vehicle; what the network does not take is lost, as on a radio."""
        self._intake.begin_step()
        self.answer([*self._call(), *datagrams])

    def answer(self, datagrams: list[bytes]) -> None:
        """Sends within a step: what is taken in is still bounded by where the step began."""
        address = self._peer
        if address is None:
            return
        if self._signing is not None:
            datagrams = self._signing.send(time.monotonic() - self._begun_s, datagrams)
        for datagram in datagrams:
            self.transport.send(datagram, address)

    def _call(self) -> list[bytes]:
        now_s = time.monotonic()
        if self._peer is None or self._autopilot.system is not None or now_s < self._call_s:
            return []
        self._call_s = now_s + CALL_S
        kind, mode = dialect.MAV_TYPE_ONBOARD_CONTROLLER, dialect.MAV_AUTOPILOT_INVALID
        here = dialect.MAVLink_heartbeat_message(kind, mode, 0, 0, dialect.MAV_STATE_ACTIVE, 3)
        return [self._caller.pack(here)]

    @property
    def _peer(self) -> Address | None:
        return self.transport.peer or self._autopilot.address

    def _verified(self, datagram: bytes) -> list[bytes]:
        if self._signing is None:
            return [datagram]
        return self._signing.receive(time.monotonic() - self._begun_s, [datagram])

    def _note(self, sender: Address, datagram: bytes) -> None:
        self._taken += 1
        self._mavlink += datagram[:1] == MAVLINK2_MAGIC
        if sender[0] not in self._hosts and len(self._hosts) < HOSTS_NAMED:
            self._hosts.add(sender[0])
            log.debug("first datagram from %s:%d, %d bytes", *sender, len(datagram))

    def wait(self, timeout_s: float) -> bool:
        """Waits until something has arrived, at most so many wall-clock seconds; whether it has."""
        return self.transport.wait(timeout_s)

    def news(self) -> list[FlightEvent]:
        """What has become of the line, and how much was dropped and refused, when that is news."""
        events = self.transport.news()
        if dropped := self._intake.news():
            events.append(DatagramsDropped(dropped))
        if self._signing is not None and (refused := self._signing.news()):
            events.append(FramesRefused(*refused))
        return events

    @property
    def has_heard(self) -> bool:
        """Whether an autopilot was heard."""
        return self._autopilot.system is not None

    def account(self) -> str:
        """What was heard so far, in words."""
        if not self._taken:
            return "nothing arrived"
        system = self._autopilot.system
        autopilot = "no autopilot" if system is None else f"the autopilot of {system}"
        account = (
            f"{self._taken} packets came from {', '.join(sorted(self._hosts))}, "
            f"{self._mavlink or 'none'} of them MAVLink 2; {autopilot} was heard"
        )
        if self._signing is None or not any(self._signing.refused):
            return account
        return f"{account}; refused: {self._signing.refused}"

    def close(self) -> None:
        """Frees the port."""
        self.transport.close()
