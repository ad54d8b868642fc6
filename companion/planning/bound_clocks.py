"""The clocks of the conjuncts that have a time bound; they run beside the automata."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass

from companion.ltl.bound_clock import BoundClock, is_true
from companion.ltl.time_bounds import TimeBound
from companion.planning.lasso import Conjunct, Letter

NO_CLOCKS: tuple[int | None, ...] = ()
"""What the clocks show if no conjunct has a bound."""


@dataclass(frozen=True, slots=True)
class ClocksRun:
    """What has changed about the clocks at one moment.

    Attributes:
        over: the conjuncts whose clock has run out just now.
        have_begun: whether the word has begun at this moment.
    """

    over: tuple[Conjunct, ...] = ()
    have_begun: bool = False

    @property
    def has_changed(self) -> bool:
        """Whether more has happened than that time has passed."""
        return self.have_begun or bool(self.over)


NOTHING_OVER = ClocksRun()


class BoundClocks:
    """One clock for each conjunct that has a bound.

    Attributes:
        are_begun: whether the word has begun.

    Args:
        conjuncts: the conjuncts of the task.
    """

    def __init__(self, conjuncts: Sequence[Conjunct]) -> None:
        self.are_begun = False
        self._conjuncts = conjuncts
        self._clocks = {
            number: BoundClock(conjunct.bound)
            for number, conjunct in enumerate(conjuncts)
            if conjunct.bound is not None
        }

    def __bool__(self) -> bool:
        """Whether any conjunct has a bound."""
        return bool(self._clocks)

    def restart(self, line: str) -> None:
        """The clocks of a line start again at the next position."""
        for i, clock in self._clocks.items():
            if self._conjuncts[i].name == line:
                self._clocks[i] = clock.restarted()

    def read(self, letter: Letter, reached_s: float, left_s: float) -> tuple[Conjunct, ...]:
        """Reads one more position. Returns the conjuncts that it finds to be late and that were not
        before.
        """
        before = self.late
        self._clocks = {
            i: clock.after(letter, _ms(reached_s), _ms(left_s)) for i, clock in self._clocks.items()
        }
        return tuple(conjunct for conjunct in self.late if conjunct not in before)

    def see(self, letter: Letter, event_s: float | None = None) -> None:
        """Notes what the next letter will contain, as far as it is known now.

        Args:
            letter: what is known of the next letter.
            event_s: when an event changed it; None if a new position changed it.
        """
        event_ms = None if event_s is None else _ms(event_s)
        self._clocks = {i: clock.seeing(letter, event_ms) for i, clock in self._clocks.items()}

    def run(self, now_s: float, unread: Letter | None) -> ClocksRun:
        """Lets time pass. The first call begins the word.

        Args:
            now_s: the present time.
            unread: the position that was reached and has not been left yet; None if there is none.
        """
        now_ms = _ms(now_s)
        if not self.are_begun:
            self._clocks = {i: clock.begun(now_ms) for i, clock in self._clocks.items()}
            self.are_begun = True
            return ClocksRun(have_begun=True)
        over = {i: c.over() for i, c in self._clocks.items() if c.is_over(now_ms, unread)}
        self._clocks |= over
        return ClocksRun(tuple(self._conjuncts[i] for i in over)) if over else NOTHING_OVER

    def are_called(self, lines: Collection[str]) -> bool:
        """Whether an event asks for the goal of one of these lines, and no position has read it
        yet.
        """
        return any(
            clock.is_called for i, clock in self._clocks.items() if self._conjuncts[i].name in lines
        )

    @property
    def late(self) -> tuple[Conjunct, ...]:
        """The conjuncts whose clock has run out."""
        return tuple(self._conjuncts[i] for i, clock in self._clocks.items() if clock.is_late)

    def without_late(
        self, states: tuple[frozenset[int], ...], restarted: Collection[str]
    ) -> tuple[frozenset[int], ...]:
        """The automaton states, empty for conjuncts that are late and do not start again."""
        late = [conjunct for conjunct in self.late if conjunct.name not in restarted]
        pairs = zip(self._conjuncts, states, strict=True)
        return tuple(frozenset() if c in late else own for c, own in pairs) if late else states

    def show(
        self,
        now_s: float,
        unread: tuple[Letter, float] | None = None,
        restarted: Collection[str] = (),
    ) -> tuple[int | None, ...]:
        """What the clocks show, for each conjunct, as if the present position were read now.

        Args:
            now_s: the present time.
            unread: the present position and when it was reached; None if it has been read already.
            restarted: lines that start again.
        """
        if not self._clocks:
            return NO_CLOCKS
        now_ms = _ms(now_s)
        shown: list[int | None] = [None] * len(self._conjuncts)
        for i, clock in self._clocks.items():
            if self._conjuncts[i].name in restarted:
                clock = clock.restarted()
            if not self.are_begun:
                clock = clock.begun(now_ms)
            if unread is not None:
                letter, reached_s = unread
                clock = clock.after(letter, _ms(reached_s) if self.are_begun else now_ms, now_ms)
            elif clock.is_new:
                clock = clock.begun(now_ms)
            shown[i] = clock.elapsed_ms(now_ms)
        return tuple(shown)


def after(bound: TimeBound, elapsed_ms: int | None, letter: Letter) -> int | None:
    """What the clock of a bound shows after a position is read; None if it stands still.

    Args:
        bound: the time bound.
        elapsed_ms: what the clock showed when the position was reached.
        letter: what holds at the position.
    """
    return bound.after(elapsed_ms, lambda formula: is_true(formula, letter))


def begun(conjuncts: Sequence[Conjunct], letter: Letter) -> tuple[int | None, ...]:
    """What the clocks show after the first position."""
    return BoundClocks(conjuncts).show(0.0, (letter, 0.0))


def _ms(seconds: float) -> int:
    return round(1000 * seconds)
