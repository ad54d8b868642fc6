"""Which beliefs are held; a withdrawn belief may return after a time, by an event or by the map.

1. If a belief has just failed and the map contradicts it, the map counts as the cause: the belief
   returns only by the map.

2. No failure is missed, just as no rise of an event is. If the task mentions a belief, it does not
   return by time before a position has read that it failed.
"""

from __future__ import annotations

import math

from companion.mission.facts import HERE, Fact


class HeldBeliefs:
    """The beliefs of a flight.

    Attributes:
        withdrawn: beliefs that were disproved or that the map contradicts.

    Args:
        mentioned: beliefs that the task mentions.
    """

    def __init__(self, mentioned: frozenset[Fact] = frozenset()) -> None:
        self.withdrawn: frozenset[Fact] = frozenset()
        self._mentioned = mentioned
        self._unread: frozenset[Fact] = frozenset()
        self._returns_s: dict[Fact, float] = {}
        self._failed: frozenset[Fact] = frozenset()
        self._cut_off: frozenset[Fact] = frozenset()

    def withdraw(self, beliefs: frozenset[Fact], retry_s: float | None) -> None:
        """Withdraws beliefs; from time `retry_s` on, if given, they may be held again."""
        self.withdrawn |= beliefs
        self._failed |= beliefs
        self._unread |= beliefs & self._mentioned
        for belief in beliefs:
            self._returns_s.pop(belief, None)
            if retry_s is not None:
                self._returns_s[belief] = retry_s

    def read(self) -> None:
        """A position was read with the beliefs that are withdrawn now."""
        self._unread = frozenset()

    def leave_here(self) -> None:
        """At another place, beliefs withdrawn about `here` no longer matter."""
        self.withdrawn = frozenset(b for b in self.withdrawn if HERE not in b.arguments)

    def cut_off(self, beliefs: frozenset[Fact]) -> tuple[list[Fact], list[Fact]]:
        """Withdraws beliefs that the map contradicts, and holds those again that it no longer does.

        Args:
            beliefs: all beliefs that the map contradicts now.

        Returns:
            The beliefs given up, and those held again.
        """
        lost, held = beliefs - self.withdrawn, self._cut_off - beliefs
        self._cut_off = (self._cut_off | lost | self._failed) & beliefs
        self._failed = frozenset()
        self.withdrawn = (self.withdrawn | lost) - held
        return sorted(lost), sorted(held)

    @property
    def returning(self) -> frozenset[Fact]:
        """The withdrawn beliefs that return by time."""
        return self.withdrawn & self._returns_s.keys()

    @property
    def is_cut_off(self) -> bool:
        """Whether the map contradicts a belief."""
        return bool(self._cut_off)

    def restore(self, now_s: float, is_waiting: bool, predicates: frozenset[str]) -> list[Fact]:
        """Holds beliefs again if their time has come or their predicate is named; returns them.

        Beliefs that the map contradicts wait for the map.

        Args:
            now_s: the present time.
            is_waiting: whether no plan leads to a position that would read the failed beliefs.
            predicates: all beliefs with these predicates return.
        """
        later = frozenset() if is_waiting else self._unread
        restored = sorted(
            belief
            for belief in self.withdrawn - self._cut_off
            if belief.predicate in predicates
            or (self._returns_s.get(belief, math.inf) <= now_s and belief not in later)
        )
        self.withdrawn -= set(restored)
        return restored
