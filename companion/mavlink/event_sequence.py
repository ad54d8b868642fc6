"""Puts the events of one component in order, each once, and requests those that were lost.

Rules:
1. The sequence begins with the first event or sequence number heard. Earlier events are not
   requested.
2. An event waits until all events before it have come. Missing events are requested every ASK_S, at
   most TRIES times, and then skipped. Events that the component reports as no longer stored are
   skipped too.
3. A number far from the expected one, or a reported reset, means that the component has started
   anew.

Source: https://mavlink.io/en/services/events.html.
"""

from __future__ import annotations

import math
from typing import Generic, TypeVar

ROUND = 65536
FAR = 64
"""More events than a component stores: PX4 stores 20."""
ASK_S = 0.5
TRIES = 6

T = TypeVar("T")


class EventSequence(Generic[T]):
    """The events of one component, in order.

    >>> events = EventSequence[str]()
    >>> for number, event in ((7, "a"), (10, "d"), (8, "b"), (8, "b")):
    ...     events.take(number, event)
    >>> events.ready(), events.due(0.0)
    (['a', 'b'], (9, 9))
    >>> events.take(9, "c")
    >>> events.ready(), events.due(0.0)
    (['c', 'd'], None)
    """

    def __init__(self) -> None:
        self._next: int | None = None
        self._missing_to = 0  # number of events known to exist from the next one on
        self._waiting: dict[int, T | None] = {}  # None: skipped
        self._ready: list[T | None] = []
        self._ask_s = -math.inf
        self._tries = 0

    @property
    def has_begun(self) -> bool:
        """Whether the component has sent anything about events."""
        return self._next is not None

    def take(self, number: int, event: T) -> None:
        """Takes an event."""
        ahead = self._ahead(number)
        if ahead < -FAR or ahead >= FAR:
            self._begin(number)
            ahead = 0
        if ahead >= 0:
            self._waiting.setdefault(number, event)
            self._missing_to = max(self._missing_to, ahead + 1)
            self._advance()

    def take_newest(self, number: int, is_reset: bool) -> None:
        """Takes the number of the newest event, which the component sends now and then."""
        ahead = self._ahead(number) + 1
        if self._next is None or is_reset or abs(ahead) > FAR:
            self._begin((number + 1) % ROUND)
        else:
            self._missing_to = max(self._missing_to, ahead)

    def pass_over(self, number: int) -> None:
        """Skips an event that cannot be had any more."""
        if 0 <= self._ahead(number) < self._missing_to:
            self._waiting.setdefault(number, None)
            self._advance()

    def ready(self) -> list[T | None]:
        """The events that are in order since the last call; None for a skipped one."""
        ready, self._ready = self._ready, []
        return ready

    def due(self, now_s: float) -> tuple[int, int] | None:
        """The first and last number to request now; None for nothing."""
        if self._next is None or not self._missing_to or now_s < self._ask_s + ASK_S:
            return None
        last = self._missing_to - 1
        waiting = [self._ahead(number) for number in self._waiting]
        if waiting:
            last = min(waiting) - 1
        first = self._next
        if self._tries >= TRIES:
            for ahead in range(last + 1):
                self._waiting[(first + ahead) % ROUND] = None
            self._advance()
            return None
        self._tries += 1
        self._ask_s = now_s
        return first, (first + last) % ROUND

    def _ahead(self, number: int) -> int:
        """How far a number is ahead of the next one expected; negative for older ones."""
        if self._next is None:
            return FAR
        return (number - self._next + ROUND // 2) % ROUND - ROUND // 2

    def _advance(self) -> None:
        while self._next in self._waiting:
            self._ready.append(self._waiting.pop(self._next))
            self._next = (self._next + 1) % ROUND
            self._missing_to = max(0, self._missing_to - 1)
            self._tries, self._ask_s = 0, -math.inf

    def _begin(self, number: int) -> None:
        self._next, self._missing_to, self._tries = number, 0, 0
        self._waiting.clear()
        self._ask_s = -math.inf
