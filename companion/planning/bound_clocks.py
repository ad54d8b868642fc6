"""The clocks of a task's bounded conjuncts, beside its automata."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass

from companion.ltl.bound_clock import BoundClock, is_true
from companion.ltl.time_bounds import TimeBound
from companion.planning.lasso import Conjunct, Letter

NO_CLOCKS: tuple[int | None, ...] = ()
"""What they show where no conjunct has a bound."""


@dataclass(frozen=True, slots=True)
class ClocksRun:
    """What has become of the clocks in a moment.

    Attributes:
        over: the conjuncts whose clock has run over just then.
        have_begun: whether the word has, with it.
    """

    over: tuple[Conjunct, ...] = ()
    have_begun: bool = False

    @property
    def has_changed(self) -> bool:
        """Whether it is news, and not time alone that has gone on."""
        return self.have_begun or bool(self.over)


NOTHING_OVER = ClocksRun()


class BoundClocks:
    """One clock for each conjunct that has a bound.

    Attributes:
        are_begun: whether the word has begun, for them.

    Args:
        conjuncts: of the task.
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
        """Whether there are any."""
        return bool(self._clocks)

    def begin_anew(self, line: str) -> None:
        """Those of a line begin anew with the next position."""
        for i, clock in self._clocks.items():
            if self._conjuncts[i].name == line:
                self._clocks[i] = clock.anew()

    def read(self, letter: Letter, reached_s: float, left_s: float) -> tuple[Conjunct, ...]:
        """One more position; those that it finds to be too late, which were not before."""
        before = self.late
        self._clocks = {
            i: clock.after(letter, _ms(reached_s), _ms(left_s)) for i, clock in self._clocks.items()
        }
        return tuple(conjunct for conjunct in self.late if conjunct not in before)

    def see(self, letter: Letter, event_s: float | None = None) -> None:
        """What the next letter will have, as far as it is known by now.

        Args:
            letter: that.
            event_s: when an event has changed it; None where a position has.
        """
        event_ms = None if event_s is None else _ms(event_s)
        self._clocks = {i: clock.seeing(letter, event_ms) for i, clock in self._clocks.items()}

    def run(self, now_s: float, unread: Letter | None) -> ClocksRun:
        """Time goes on. With the first call the word begins.

        Args:
            now_s: the time.
            unread: the position that was reached and not left yet; None if there is none.
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
        """Whether an event asks for the goal of one of some lines, and no position has read it."""
        return any(
            clock.is_called for i, clock in self._clocks.items() if self._conjuncts[i].name in lines
        )

    @property
    def late(self) -> tuple[Conjunct, ...]:
        """The conjuncts whose clock has run over."""
        return tuple(self._conjuncts[i] for i, clock in self._clocks.items() if clock.is_late)

    def without_late(
        self, states: tuple[frozenset[int], ...], anew: Collection[str]
    ) -> tuple[frozenset[int], ...]:
        """The states of the automata, none for conjuncts that are late and do not begin anew."""
        late = [conjunct for conjunct in self.late if conjunct.name not in anew]
        pairs = zip(self._conjuncts, states, strict=True)
        return tuple(frozenset() if c in late else own for c, own in pairs) if late else states

    def show(
        self,
        now_s: float,
        unread: tuple[Letter, float] | None = None,
        anew: Collection[str] = (),
    ) -> tuple[int | None, ...]:
        """What they show, for each conjunct; as if the present position were read.

        Args:
            now_s: the time.
            unread: the present position and when it was reached; None if it is read already.
            anew: lines that begin anew.
        """
        if not self._clocks:
            return NO_CLOCKS
        now_ms = _ms(now_s)
        shown: list[int | None] = [None] * len(self._conjuncts)
        for i, clock in self._clocks.items():
            if self._conjuncts[i].name in anew:
                clock = clock.anew()
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
    """What the clock of a bound shows once a position was read; None if it stands still.

    Args:
        bound: what it says.
        elapsed_ms: what it showed when the position was reached.
        letter: what holds there.
    """
    return bound.after(elapsed_ms, lambda formula: is_true(formula, letter))


def begun(conjuncts: Sequence[Conjunct], letter: Letter) -> tuple[int | None, ...]:
    """The clocks after the first position."""
    return BoundClocks(conjuncts).show(0.0, (letter, 0.0))


def _ms(seconds: float) -> int:
    return round(1000 * seconds)
