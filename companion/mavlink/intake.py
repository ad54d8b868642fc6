"""How much of what arrives at a port is taken in, so that no flood holds up a loop.

Any program can send to a port, and more than a step of a loop can read. The rules:

1. A datagram longer than `LONGEST` is refused.
2. What a sender may have taken in a step is counted in frames; 64 bytes count as a frame at least,
   so that bytes are bounded as well. All work that follows is bounded by it: each frame is decoded
   a few times at most.
3. The known peer has a share of its own, which nobody else can use up. Each other sender has a
   share, and all of them together have one more.
4. The datagram that exceeds a share is the last that is taken; what follows is dropped unread.
   What is refused or dropped is counted.

It is counted and never timed: the same datagrams are taken whatever else the machine does. No I/O.
"""

from __future__ import annotations

from companion.mavlink.framing import split_frames

LONGEST = 2048
"""Bytes of a datagram: seven of the longest frames, and more than an Ethernet packet holds."""
READS = 2048
"""Datagrams that are read from a port at once, a few milliseconds: a flood may never end."""
PEER_FRAMES = 512
"""Two seconds of what PX4 sends to a companion, as after a loop that was held up."""
SENDER_FRAMES = 128
STRANGERS_FRAMES = 256
_BYTES_PER_FRAME = 64

Address = tuple[str, int]
"""Host and port."""


class Intake:
    """Takes in datagrams of one port, in steps.

    Attributes:
        dropped: datagrams that were not taken since the beginning.

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
        """From now on every sender has its whole share again."""
        self._left: dict[Address, int] = {}
        self._left_for_strangers = STRANGERS_FRAMES

    def takes(self, sender: Address, datagram: bytes, peer: Address | None) -> bool:
        """Whether a datagram is taken in; it counts.

        Args:
            sender: where it came from.
            datagram: what came, or more than its first `LONGEST` bytes.
            peer: the sender that the loop cannot do without, if it is known.
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
        """How many were dropped so far, when twice as many as were told last; else 0.

        Twice as many: a flood is told at once, and in a line now and then while it lasts.
        """
        if not is_news(self.dropped, self._told):
            return 0
        self._told = self.dropped
        return self._told


def is_news(count: int, told: int) -> bool:
    """Whether a count that only grows is told again: when it has doubled since."""
    return count >= max(1, 2 * told)
