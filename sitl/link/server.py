"""The UDP door: PX4's ports.

Each link has a local port and a port where its peer is expected. Instance i adds i to all of them
except the ground station's: one ground station sees all vehicles.

    GCS       local 18570, sends to 127.0.0.1:14550
    OFFBOARD  local 14580, sends to 127.0.0.1:14540

PX4 does the same (ROMFS/px4fmu_common/init.d-posix/px4-rc.mavlink), but from instance 10 on it
sends to 14549; here counting continues.

1. Whoever sends to the local port becomes the peer, so a client on another port is answered there.
2. Only this machine is listened to.
3. The number of datagrams taken at once is limited for each link (`companion/mavlink/intake.py`).
4. It is no error if nobody listens.

The only other file with a socket is `report_sender.py`.
"""

from __future__ import annotations

import select
import socket

from companion.errors import LinkError
from companion.mavlink.intake import LONGEST, READS, Intake
from sitl.link.routing import LinkName

HOST = "127.0.0.1"
LOCAL_PORTS = {LinkName.GCS: 18570, LinkName.OFFBOARD: 14580}
COMPANION_PORT, GROUND_PORT = 14540, 14550

BUFFER_BYTES = 1 << 20  # a client that lists all parameters at once sends and receives bursts


class Server:
    """The sockets of one instance; use it in a `with` statement.

    Args:
        instance: selects the ports.
        ground_port: where a ground station is expected.

    Attributes:
        peers: the expected peer of each link, or the one that has sent last.

    Raises:
        LinkError: a local port is in use, or ground station and companion would share a port.
    """

    def __init__(self, instance: int, ground_port: int = GROUND_PORT) -> None:
        self.instance = instance
        companion_port = COMPANION_PORT + instance
        if companion_port == ground_port:
            raise LinkError(
                f"instance {instance} would expect its companion on UDP port {ground_port}, as the "
                f"ground station; choose another instance with -i, or a --ground-port"
            )
        self.peers = {
            LinkName.GCS: (HOST, ground_port),
            LinkName.OFFBOARD: (HOST, companion_port),
        }
        self._sockets: dict[LinkName, socket.socket] = {}
        self._intakes = {link: Intake() for link in LOCAL_PORTS}
        for link, local in LOCAL_PORTS.items():
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
        """Closes the sockets."""
        for udp in self._sockets.values():
            udp.close()

    def receive(self, timeout_s: float) -> list[tuple[LinkName, bytes]]:
        """The accepted datagrams, in order for each link; waits for the first."""
        links = {udp: link for link, udp in self._sockets.items()}
        ready, _, _ = select.select(list(links), [], [], max(0.0, timeout_s))
        return [(links[udp], datagram) for udp in ready for datagram in self._drain(links[udp])]

    def send(self, frames: list[tuple[LinkName, bytes]]) -> None:
        """Sends each frame as a datagram to its link's peer."""
        for link, frame in frames:
            try:
                self._sockets[link].sendto(frame, self.peers[link])
            except OSError:
                continue  # nobody listens, or the buffer is full: UDP promises nothing

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
