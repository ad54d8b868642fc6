"""The relay that lets MAVSDK, which cannot sign, talk to a signed vehicle.

It uses two UDP sockets in the loop of the command. One is the link to the vehicle
(`vehicle/link.py`), where frames are signed and verified. The other, on this machine, serves
MAVSDK, which receives only accepted frames. Whatever another program sends there is dropped.
"""

from __future__ import annotations

import asyncio
import socket
from collections.abc import Iterator
from contextlib import closing, contextmanager

from companion.mavlink.framing import split_frames
from companion.mavlink.intake import LONGEST, READS, Address
from companion.mavlink.signing import Signing
from companion.vehicle.endpoints import Endpoint
from companion.vehicle.link import Link

HOST = "127.0.0.1"
PAUSE_S = 0.005
"""Pause between two looks; a serial port that is reopened has no descriptor to wait for."""


@contextmanager
def relayed(endpoint: Endpoint, signing: Signing) -> Iterator[SigningRelay]:
    """A relay in the running loop, while the context lasts.

    Raises:
        LinkError: the port to the vehicle cannot be opened.
    """
    with (
        closing(Link(endpoint, signing, calls=False)) as link,
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as inner,
    ):
        inner.setblocking(False)
        inner.bind((HOST, 0))
        relay, loop = SigningRelay(link, inner), asyncio.get_running_loop()
        carrying = loop.create_task(relay.carry())
        try:
            yield relay
        finally:
            carrying.cancel()


class SigningRelay:
    """Carries datagrams between a signed link and a client that does not sign.

    Args:
        link: to the vehicle.
        inner: the socket to which the client sends.

    Attributes:
        url: the address for the client.
    """

    def __init__(self, link: Link, inner: socket.socket) -> None:
        self.url = f"udpout://{HOST}:{inner.getsockname()[1]}"
        self.account = link.account
        self._link = link
        self._inner = inner
        self._client: Address | None = None

    async def carry(self) -> None:
        """Carries in both directions until it is cancelled."""
        while True:
            self.carry_in()
            self.carry_out()
            await asyncio.sleep(PAUSE_S)

    def carry_in(self) -> None:
        """Carries accepted frames from the vehicle to the client."""
        for datagram in self._link.receive():
            if self._client is not None:
                self._inner.sendto(datagram, self._client)
        self._link.send([])

    def carry_out(self) -> None:
        """Carries frames from the client to the vehicle, signed."""
        frames: list[bytes] = []
        for _ in range(READS):
            try:
                datagram, sender = self._inner.recvfrom(LONGEST)
            except BlockingIOError:
                break
            except ConnectionError:  # the client has closed its port
                continue
            self._client = self._client or sender
            if sender == self._client:
                frames += split_frames(datagram)
        self._link.send(frames)
