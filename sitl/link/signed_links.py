"""Message signing on the links, as PX4 does it: with a key, on all of them.

What the components on board say is signed for the link on which it leaves. What is forwarded stays
as it came: with the signature of who has sent it, or unsigned where that is accepted.
"""

from __future__ import annotations

from collections.abc import Container

from companion.mavlink.signing import Signing
from sitl.link.routing import LinkName

LINK_IDS = {link: number for number, link in enumerate(LinkName)}

Datagrams = list[tuple[LinkName, bytes]]
"""Each with its link."""


def verified(signing: Signing, now_s: float, datagrams: Datagrams) -> Datagrams:
    """The frames that are accepted, in order. A frame counts once, whichever link it comes on."""
    return [(link, f) for link, d in datagrams for f in signing.receive(now_s, [d])]


def signed(
    signing: Signing, now_s: float, frames: Datagrams, local: Container[tuple[int, int]]
) -> Datagrams:
    """The frames that leave, those of components on board with a signature.

    Args:
        signing: of the vehicle.
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
