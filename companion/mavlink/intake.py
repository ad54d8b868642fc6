"""Limits how much of what arrives at a port is taken in, so that a flood does not delay the loop.

Any program can send to a port, and send more than a step of a loop can read. The rules:

1. A datagram longer than `LONGEST` is refused.
2. The share of a sender in a step is counted in frames; each 64 bytes count as one frame at least,
   so that bytes are bounded as well. This bounds all later work: each frame is decoded only a few
   times.
3. The known peer has its own share, which nobody else can use up. Each other sender has a share,
   and all others together have one more.
4. The datagram that exceeds a share is the last one taken; later ones are dropped unread. Refused
   and dropped datagrams are counted.

Limits are counts, never times: the same datagrams are taken whatever else the machine does. No I/O.
"""

from __future__ import annotations

from companion.mavlink.framing import split_frames

LONGEST = 2048
"""Bytes of a datagram: seven of the longest frames, and more than an Ethernet packet holds."""
READS = 2048
"""Datagrams that are read from a port at once, which takes a few milliseconds: a flood may never
end."""
PEER_FRAMES = 512
"""What PX4 sends to a companion in two seconds, as after a delay of the loop."""
SENDER_FRAMES = 128
STRANGERS_FRAMES = 256
_BYTES_PER_FRAME = 64

Address = tuple[str, int]
"""Host and port."""


class Intake:
    """Takes in the datagrams of one port, in steps.

    Attributes:
        dropped: datagrams that were not taken so far.

    >>> intake = Intake()
    >>> intake.takes(("10.0.0.7", 14550), bytes(2048), peer=None)
    True
    >>> intake.takes(("10.0.0.7", 14550), bytes(2049), peer=None), intake.dropped
    (False, 1)
    """

    def __init__(self) -> None:
        self.dropped = 0
        self._told = 0
        self.begin_step()

    def begin_step(self) -> None:
        """Gives every sender its whole share again."""
        self._left: dict[Address, int] = {}
        self._left_for_strangers = STRANGERS_FRAMES

    def takes(self, sender: Address, datagram: bytes, peer: Address | None) -> bool:
        """Whether a datagram is taken in; counts it.

        Args:
            sender: where it came from.
            datagram: its bytes, or more than the first `LONGEST` of them.
            peer: the sender that the loop depends on, if it is known.
        """
        is_peer = sender == peer
        left = self._left.get(sender, PEER_FRAMES if is_peer else SENDER_FRAMES)
        has_room = left > 0 and (is_peer or self._left_for_strangers > 0)
        if len(datagram) > LONGEST or not has_room:
            self.dropped += 1
            return False
        cost = max(1, len(split_frames(datagram)), len(datagram) // _BYTES_PER_FRAME)
        self._left[sender] = left - cost
        if not is_peer:
            self._left_for_strangers -= cost
        return True

    def news(self) -> int:
        """How many were dropped so far, if that is twice as many as last reported; otherwise 0.

        So a flood is reported at once, and then now and again while it lasts.
        """
        if not is_news(self.dropped, self._told):
            return 0
        self._told = self.dropped
        return self._told


def is_news(count: int, told: int) -> bool:
    """Whether a growing count is worth reporting: it has doubled since the last report."""
    return count >= max(1, 2 * told)
