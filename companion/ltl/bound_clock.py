"""The clock of a time bound, which reads a word position by position.

1. An event asks for a goal from the moment at which it comes, not only from the position at which
   it is read: the vehicle reads the next position only on arrival. An event that meets a goal
   likewise meets it at that moment.
2. A goal that was asked for before, and still is, is asked for again from each position that says
   so.
3. Between two positions a clock continues, and may run out. A position that was reached in time
   counts, even if it is read later.
4. A clock that starts again shows 0 until the vehicle leaves the next position.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from companion.ltl.formula import Formula
from companion.ltl.semantics import Letter, holds
from companion.ltl.time_bounds import Response, TimeBound


@dataclass(frozen=True)
class BoundClock:
    """A bound and the time since which it runs. Times are in milliseconds; only differences matter.

    >>> from companion.ltl.parser import atom
    >>> from companion.ltl.time_bounds import Within
    >>> clock = BoundClock(Within(atom("p"), 9000)).begun(1000)
    >>> clock.is_over(10_000, None), clock.is_over(10_001, None)
    (False, True)

    Attributes:
        since_ms: None while the clock stands still.
        asked_ms: when an event asked for the goal, if no position has read that yet.
        is_asking: whether the goal is asked for, as far as is known now.
        met_ms: when an event met the goal in time, if no position has read that yet.
        is_met: whether the goal holds, as far as is known now.
        is_new: whether the clock starts again when the next position is left.
        is_late: whether the clock has run out; this is final, unless it starts again.
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
        """The clock at the beginning of the word."""
        since_ms = now_ms if self.bound.begin() is not None else None
        return replace(self, since_ms=since_ms, asked_ms=None, met_ms=None)

    def restarted(self) -> BoundClock:
        """A clock that starts again at the next position and forgets what was before."""
        return BoundClock(self.bound, is_new=True)

    def seeing(self, letter: Letter, event_ms: int | None = None) -> BoundClock:
        """The clock with what the next letter will contain, as far as it is known now.

        Args:
            letter: what is known of the next letter.
            event_ms: when an event changed it; None if a new position changed it.
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
        """Whether an event asks for the goal and no position has read that yet."""
        return self.since_ms is None and self.asked_ms is not None and self.met_ms is None

    def is_over(self, now_ms: int, unread: Letter | None) -> bool:
        """Whether the clock has run out by now, and had not before.

        Args:
            now_ms: the present time.
            unread: the position that was reached and has not been left yet; None if there is none.
        """
        if self.is_late or not self.bound.is_late(self.elapsed_ms(now_ms)):
            return False
        return unread is None or not is_true(self.bound.goal, unread)

    def over(self) -> BoundClock:
        """The clock, marked as run out."""
        return replace(self, is_late=True)

    def elapsed_ms(self, now_ms: int) -> int | None:
        """What the clock shows; None if it stands still, as after an event has met the goal."""
        if self.met_ms is not None:
            return None
        since = self.since_ms if self.since_ms is not None else self.asked_ms
        return None if since is None else max(0, now_ms - since)

    def after(self, letter: Letter, reached_ms: int, left_ms: int) -> BoundClock:
        """The clock after one more position is read.

        Args:
            letter: what holds at the position.
            reached_ms: when the vehicle reached it.
            left_ms: when the vehicle left it.
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
