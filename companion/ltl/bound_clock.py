"""The clock of a bound as it reads a word in time, position by position.

What an event asks for is asked for from the moment in which it comes, not only from the position at
which it is read: a vehicle reads next where it arrives. A goal that an event meets is met in that
moment, too. What was asked for before, and still is, is asked for from each position on that says
so. Between two positions a clock goes on, and may run over; a position that was reached in time
counts, although it is read later.

A clock that begins anew stands at 0 until the next position is left.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from companion.ltl.formula import Formula
from companion.ltl.semantics import Letter, holds
from companion.ltl.time_bounds import Response, TimeBound


@dataclass(frozen=True)
class BoundClock:
    """A bound, and since when it runs; times are in milliseconds, of which differences matter.

    >>> from companion.ltl.parser import atom
    >>> from companion.ltl.time_bounds import Within
    >>> clock = BoundClock(Within(atom("p"), 9000)).begun(1000)
    >>> clock.is_over(10_000, None), clock.is_over(10_001, None)
    (False, True)

    Attributes:
        since_ms: None while it stands still.
        asked_ms: when an event asked for it, which no position has read yet.
        is_asking: whether it is asked for by what is known now.
        met_ms: when an event met the goal in time, which no position has read yet.
        is_met: whether the goal holds by what is known now.
        is_new: it begins anew with the next position that is left.
        is_late: it has run over; for ever, unless it begins anew.
    """

    bound: TimeBound
    since_ms: int | None = None
    asked_ms: int | None = None
    is_asking: bool = False
    met_ms: int | None = None
    is_met: bool = False
    is_new: bool = False
    is_late: bool = False

    def begun(self, now_ms: int) -> BoundClock:
        """The word begins."""
        since_ms = now_ms if self.bound.begin() is not None else None
        return replace(self, since_ms=since_ms, asked_ms=None, met_ms=None)

    def anew(self) -> BoundClock:
        """It begins anew with the next position; what was, is forgotten."""
        return BoundClock(self.bound, is_new=True)

    def seeing(self, letter: Letter, event_ms: int | None = None) -> BoundClock:
        """With what the next letter will have, as far as it is known by now.

        Args:
            letter: that.
            event_ms: when an event has changed it; None where a position has.
        """
        if self.is_new:
            return self
        is_asking, is_met = self._asks(letter), is_true(self.bound.goal, letter)
        begins = is_asking and not self.is_asking
        asked_ms = (event_ms if begins else self.asked_ms) if is_asking else None
        seen = replace(self, asked_ms=asked_ms, is_asking=is_asking, is_met=is_met)
        if not is_met:
            return replace(seen, met_ms=None)
        if event_ms is None or not (begins or not self.is_met):
            return seen
        in_time = not self.bound.is_late(seen.elapsed_ms(event_ms))
        return replace(seen, met_ms=event_ms) if in_time else seen

    def _asks(self, letter: Letter) -> bool:
        return isinstance(self.bound, Response) and is_true(self.bound.trigger, letter)

    @property
    def is_called(self) -> bool:
        """Whether an event asks for its goal, which no position has read yet."""
        return self.since_ms is None and self.asked_ms is not None and self.met_ms is None

    def is_over(self, now_ms: int, unread: Letter | None) -> bool:
        """Whether it has run over by now, and had not before.

        Args:
            now_ms: the time.
            unread: the position that was reached and not left yet; None if there is none.
        """
        if self.is_late or not self.bound.is_late(self.elapsed_ms(now_ms)):
            return False
        return unread is None or not is_true(self.bound.goal, unread)

    def over(self) -> BoundClock:
        """It has run over."""
        return replace(self, is_late=True)

    def elapsed_ms(self, now_ms: int) -> int | None:
        """What it shows; None if it stands still, as it does once an event has met the goal."""
        if self.met_ms is not None:
            return None
        since = self.since_ms if self.since_ms is not None else self.asked_ms
        return None if since is None else max(0, now_ms - since)

    def after(self, letter: Letter, reached_ms: int, left_ms: int) -> BoundClock:
        """One more position that was read.

        Args:
            letter: what holds there.
            reached_ms: when it was reached.
            left_ms: when it was left.
        """
        if self.is_new:
            return replace(self.begun(left_ms), is_new=False).after(letter, left_ms, left_ms)
        is_asking, is_met = self._asks(letter), is_true(self.bound.goal, letter)
        since, met_ms = self.since_ms, self.met_ms if is_met else None
        if since is None and is_asking:
            since = self.asked_ms
        elapsed = None if since is None or met_ms is not None else max(0, reached_ms - since)
        shown = self.bound.after(elapsed, lambda formula: is_true(formula, letter))
        if shown is None or since is None or shown != elapsed:
            since = None if shown is None else max(reached_ms, met_ms or reached_ms) - shown
        is_late = self.is_late or self.bound.is_late(elapsed)
        read = BoundClock(self.bound, since, is_late=is_late)
        return replace(read, is_asking=is_asking, is_met=is_met)


def is_true(formula: Formula, letter: Letter) -> bool:
    """Whether a formula without temporal operators holds at a position."""
    return holds(formula, (), (letter,))
