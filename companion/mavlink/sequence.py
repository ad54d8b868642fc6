"""Detects messages that a newer one of their kind has overtaken, by their sequence numbers.

UDP may reorder datagrams, and an old position or mode must not replace a newer one. Every MAVLink
message of a component on a link carries a sequence number, which wraps around after 255. The
numbers of all messages are unwrapped to one growing count. So even messages that come once a
second, with hundreds of others in between, can be compared.
"""

from __future__ import annotations

import math

ROUND = 256
SILENCE_S = 0.25  # after a longer pause the next message counts as newer


class SequenceTracker:
    """The order in which one component sent its messages on one link.

    >>> order = SequenceTracker()
    >>> [order.is_overtaken(0.0, "HEARTBEAT", number) for number in (254, 0, 255, 0)]
    [False, False, True, False]
    """

    def __init__(self) -> None:
        self._newest = 0
        self._heard_s = -math.inf
        self._of_kind: dict[str, int] = {}

    def is_overtaken(self, now_s: float, kind: str, number: int) -> bool:
        """Takes a message; returns whether a newer one of its kind has come before it.

        Args:
            now_s: when it arrived.
            kind: its type.
            number: its sequence number, 0 to 255.
        """
        ahead = (number - self._newest) % ROUND
        if ahead >= ROUND // 2 and now_s - self._heard_s < SILENCE_S:
            ahead -= ROUND
        count = self._newest + ahead
        self._newest = max(self._newest, count)
        self._heard_s = now_s
        if count < self._of_kind.get(kind, count):
            return True
        self._of_kind[kind] = count
        return False
