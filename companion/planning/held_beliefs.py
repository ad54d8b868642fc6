"""Which beliefs are held: those that were disproved may come back by time, by an event, by the map.

A belief that has just failed, and that the map contradicts, has failed for the map's sake: it waits
for the map.

No failure is lost, as no rise of an event is: a belief that the task mentions does not come back by
time on the way to the position that reads that it has failed.
"""

from __future__ import annotations

import math

from companion.mission.facts import HERE, Fact


class HeldBeliefs:
    """The beliefs of a flight.

    Attributes:
        withdrawn: those that were disproved, or that the map contradicts.

    Args:
        mentioned: what the task mentions.
    """

    def __init__(self, mentioned: frozenset[Fact] = frozenset()) -> None:
        self.withdrawn: frozenset[Fact] = frozenset()
        self._mentioned = mentioned
        self._unread: frozenset[Fact] = frozenset()
        self._returns_s: dict[Fact, float] = {}
        self._failed: frozenset[Fact] = frozenset()
        self._cut_off: frozenset[Fact] = frozenset()

    def withdraw(self, beliefs: frozenset[Fact], retry_s: float | None) -> None:
        """Gives up beliefs; from `retry_s` on, if given, they may be held again."""
        self.withdrawn |= beliefs
        self._failed |= beliefs
        self._unread |= beliefs & self._mentioned
        for belief in beliefs:
            self._returns_s.pop(belief, None)
            if retry_s is not None:
                self._returns_s[belief] = retry_s

    def read(self) -> None:
        """A position was read with those that are withdrawn."""
        self._unread = frozenset()

    def leave_here(self) -> None:
        """What was withdrawn about a place between places is of no account at another one."""
        self.withdrawn = frozenset(b for b in self.withdrawn if HERE not in b.arguments)

    def cut_off(self, beliefs: frozenset[Fact]) -> tuple[list[Fact], list[Fact]]:
        """Gives up the beliefs that the map contradicts, and holds again those that it did before.

        Args:
            beliefs: all that the map contradicts now.

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
        """The withdrawn beliefs that are held again when their time has come."""
        return self.withdrawn & self._returns_s.keys()

    @property
    def is_cut_off(self) -> bool:
        """Whether the map contradicts a belief."""
        return bool(self._cut_off)

    def restore(self, now_s: float, is_waiting: bool, predicates: frozenset[str]) -> list[Fact]:
        """Holds beliefs again whose time has come, or whose predicate is named; which ones.

        Those that the map contradicts wait for the map.

        Args:
            now_s: the time.
            is_waiting: whether no plan leads to a position that would read what has failed.
            predicates: of which all come back.
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
