"""The door of the flight side: carries bytes to and from one vehicle. All other modules are pure.

1. `endpoints.py` lists the kinds of links; `transport.py` carries the bytes.
2. Answers go to the autopilot that sends heartbeats (`autopilot_address.py`). If the other end is
   known beforehand, the companion calls it with one heartbeat a second until it is heard, as it may
   wait to be spoken to.
3. A step of the loop lasts from one `send` to the next. Whatever arrives, what is received in a
   step is bounded (`companion/mavlink/intake.py`); the address that is sent to has its own share.
4. With a key, frames are signed and verified here (`companion/mavlink/signing.py`), before anything
   is learned from them.
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
"""Number of senders that are named; a flood may come from any number."""
CALL_S = 1.0
CALLED_SYSTEM = 1
"""The system id used to call a vehicle whose id is not known; PX4's default."""

log = logging.getLogger(__name__)


class Link:
    """Sends datagrams to one vehicle and receives its datagrams.

    Args:
        endpoint: our end of the link.
        signing: signs and verifies the frames; None for a link without signatures.
        calls: whether it belongs to a companion, which calls the vehicle; one that only forwards
            does not.

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
        """The datagrams that have arrived, up to the limits of a step."""
        datagrams: list[bytes] = []
        for datagram, sender in self.transport.receive():
            if self._intake.takes(sender, datagram, self._peer):
                self._note(sender, datagram)
                for accepted in self._verified(datagram):
                    datagrams.append(accepted)
                    self._autopilot.hear(time.monotonic(), sender, accepted)
        return datagrams

    def discard(self) -> None:
        """Drops what has arrived so far, as it is out of date."""
        self.transport.discard()

    def send(self, datagrams: list[bytes]) -> None:
        """Begins a step and sends to the vehicle; what the network does not take is lost, as on a
        radio.
        """
        self._intake.begin_step()
        self.answer([*self._call(), *datagrams])

    def answer(self, datagrams: list[bytes]) -> None:
        """Sends within a step, without beginning a new one."""
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
        """Waits until something arrives, at most `timeout_s` of wall-clock time; returns whether it
        has.
        """
        return self.transport.wait(timeout_s)

    def news(self) -> list[FlightEvent]:
        """What became of the line, and how much was dropped and refused, if that is news."""
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
