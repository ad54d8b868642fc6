"""The events of one component in their order, each once; those that were lost are asked for.

Rules:
1. The first event that is heard, or the first number that is told, is where it begins: what was
   before is not asked for.
2. An event waits until those before it have come. What is missing is asked for every ASK_S, at most
   TRIES times, and then passed over; so is what the component says that it no longer has.
3. A number that is far from the one expected, or a reset that is told, is a component that has
   begun anew.

Source: https://mavlink.io/en/services/events.html.
"""

from __future__ import annotations

import math
from typing import Generic, TypeVar

ROUND = 65536
FAR = 64
"""More events than a component keeps: PX4 has 20."""
ASK_S = 0.5
TRIES = 6

T = TypeVar("T")


class EventSequence(Generic[T]):
    """The events of one component.

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
        self._missing_to = 0  # how many are known of from the next on
        self._waiting: dict[int, T | None] = {}  # None: passed over
        self._ready: list[T | None] = []
        self._ask_s = -math.inf
        self._tries = 0

    @property
    def has_begun(self) -> bool:
        """Whether the component has told of events at all."""
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
        """Takes the number of the newest event, as it is told now and then."""
        ahead = self._ahead(number) + 1
        if self._next is None or is_reset or abs(ahead) > FAR:
            self._begin((number + 1) % ROUND)
        else:
            self._missing_to = max(self._missing_to, ahead)

    def pass_over(self, number: int) -> None:
        """An event is no longer to be had."""
        if 0 <= self._ahead(number) < self._missing_to:
            self._waiting.setdefault(number, None)
            self._advance()

    def ready(self) -> list[T | None]:
        """The events that have come since the last time, in order; None for one passed over."""
        ready, self._ready = self._ready, []
        return ready

    def due(self, now_s: float) -> tuple[int, int] | None:
        """The numbers, first and last, to ask for now; None for nothing."""
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
        """How far a number is from the next one expected; negative for older ones."""
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
