"""Message signing on the links, as in PX4: one key for all of them.

Messages of components on board are signed for the link on which they leave. Forwarded messages stay
as they arrived: with the sender's signature, or unsigned where that is accepted.
"""

from __future__ import annotations

from collections.abc import Container

from companion.mavlink.signing import Signing
from sitl.link.routing import LinkName

LINK_IDS = {link: number for number, link in enumerate(LinkName)}

Datagrams = list[tuple[LinkName, bytes]]
"""Datagrams, each with its link."""


def verified(signing: Signing, now_s: float, datagrams: Datagrams) -> Datagrams:
    """The accepted frames, in order. A frame counts once, whichever link it arrives on."""
    return [(link, f) for link, d in datagrams for f in signing.receive(now_s, [d])]


def signed(
    signing: Signing, now_s: float, frames: Datagrams, local: Container[tuple[int, int]]
) -> Datagrams:
    """The frames to send; those of components on board are signed.

    Args:
        signing: the vehicle's key and time stamps.
        now_s: simulated time.
        frames: MAVLink 2, one in a datagram.
        local: addresses of the components on board.
    """
    return [
        (link, signing.send(now_s, [frame], LINK_IDS[link])[0])
        if (frame[5], frame[6]) in local
        else (link, frame)
        for link, frame in frames
    ]
