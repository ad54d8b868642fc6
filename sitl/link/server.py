"""The UDP door: PX4's ports.

Each link has a local port and the port where its peer is expected; instance i adds i to all:

    GCS       local 18570, sends to 127.0.0.1:14550
    OFFBOARD  local 14580, sends to 127.0.0.1:14540

Whoever sends to the local port becomes the peer, so that a client on another port is answered
where it is. Only this machine is listened to. What is received at once is bounded, on each link for
itself (`companion/mavlink/intake.py`). Nobody listening is no error. This is the only file with
sockets.
"""

from __future__ import annotations

import select
import socket

from companion.errors import LinkError
from companion.mavlink.intake import LONGEST, READS, Intake
from sitl.link.routing import LinkName

HOST = "127.0.0.1"
PORTS = {LinkName.GCS: (18570, 14550), LinkName.OFFBOARD: (14580, 14540)}
"""Link -> local port, peer's port."""

BUFFER_BYTES = 1 << 20  # a client that lists all parameters at once sends and gets bursts


class Server:
    """The sockets of one instance; use it in a `with` statement.

    Raises:
        LinkError: a local port is taken.
    """

    def __init__(self, instance: int) -> None:
        self.peers = {link: (HOST, peer + instance) for link, (_, peer) in PORTS.items()}
        self._sockets: dict[LinkName, socket.socket] = {}
        self._intakes = {link: Intake() for link in PORTS}
        for link, (local, _) in PORTS.items():
            self._sockets[link] = udp = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
            udp.setblocking(False)
            udp.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, BUFFER_BYTES)
            try:
                udp.bind((HOST, local + instance))
            except OSError as error:
                self.close()
                raise LinkError(
                    f"UDP port {local + instance} is taken: another simulator may run; "
                    f"choose another instance with -i"
                ) from error

    def __enter__(self) -> Server:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Gives the ports back."""
        for udp in self._sockets.values():
            udp.close()

    def receive(self, timeout_s: float) -> list[tuple[LinkName, bytes]]:
        """The datagrams that are taken in, in order for each link; waits for the first."""
        links = {udp: link for link, udp in self._sockets.items()}
        ready, _, _ = select.select(list(links), [], [], max(0.0, timeout_s))
        return [(links[udp], datagram) for udp in ready for datagram in self._drain(links[udp])]

    def send(self, frames: list[tuple[LinkName, bytes]]) -> None:
        """Sends each frame as a datagram to its link's peer."""
        for link, frame in frames:
            try:
                self._sockets[link].sendto(frame, self.peers[link])
            except OSError:
                continue  # nobody listens there, or the buffer is full: UDP promises nothing

    def _drain(self, link: LinkName) -> list[bytes]:
        datagrams: list[bytes] = []
        intake = self._intakes[link]
        intake.begin_step()
        for _ in range(READS):
            try:
                datagram, sender = self._sockets[link].recvfrom(LONGEST + 1)
            except BlockingIOError:
                break
            except OSError:
                continue  # ECONNREFUSED of an earlier send
            if intake.takes(sender, datagram, self.peers[link]):
                self.peers[link] = sender
                datagrams.append(datagram)
        return datagrams
