"""Long work in slices: what takes longer than a tick is done in parts, and setpoints leave between.

A flight plans in the loop that sends its setpoints. So planning works in slices: wherever it takes
long it says `spent`, with about how long the steps before took, and when this adds up to a slice it
is put aside, in the middle of whatever it does, until the next tick. The times are rated and
counted, not measured: equal flights have equal slices on every machine.

Work in slices is a coroutine (greenlet), so the functions between need not know. What else happens
in between happens at a `spent`: work that reads what may change there takes a copy before. Outside
of slices `spent` does nothing, and work takes the time it takes.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Generic, TypeVar
from weakref import WeakSet

from greenlet import getcurrent, greenlet

SLICE_US = 8_000
"""Work of a tick, as rated; on slower machines it is more, and two in a tick must leave time."""

T = TypeVar("T")


class InSlices(Generic[T]):
    """Work that is done in slices.

    >>> def add_up() -> int:
    ...     for _ in range(5):
    ...         spent(4_000)
    ...     return 5
    >>> adding = InSlices(add_up)
    >>> adding.step(), adding.step(), adding.step(), adding.result
    (False, False, True, 5)

    Args:
        work: what is to be done. An exception of it leaves `step`.
        slice_us: work of a step, as rated; None for `SLICE_US`.
    """

    def __init__(self, work: Callable[[], T], slice_us: float | None = None) -> None:
        self._routine = _Routine(self._run)
        _UNDER_WAY.add(self._routine)
        self._work = work
        self._slice_us = slice_us

    def _run(self) -> None:
        self.result = self._work()

    def step(self) -> bool:
        """The slice of a tick; whether the work is done."""
        if not self._routine.dead:
            self._routine.left_us = self._slice_us or SLICE_US
            self._routine.parent = getcurrent()
            self._routine.switch()
        return self._routine.dead

    def abandon(self) -> None:
        """The work is ended where it was put aside."""
        if not self._routine.dead:
            self._routine.throw()


class _Routine(greenlet):
    """The coroutine of some work.

    Attributes:
        left_us: of the slice.
    """

    left_us: float = 0.0


_UNDER_WAY: WeakSet[_Routine] = WeakSet()


def abandon_all() -> None:
    """All work that was begun from here is ended where it was put aside, at the end of a flight.

    The interpreter does not look through what is put aside: at its exit all that such work refers
    to would be left, which libraries written in C++ report on standard error.

    >>> adding = InSlices(lambda: spent(9_000))
    >>> adding.step(), abandon_all(), adding.step()
    (False, None, True)
    """
    here = getcurrent()
    for routine in [*_UNDER_WAY]:
        if not routine.dead and routine.parent is here:
            routine.throw()


def spent(work_us: float) -> None:
    """Says how long the steps before took, about; puts the work aside where a slice is over."""
    routine = getcurrent()
    if isinstance(routine, _Routine):
        routine.left_us -= work_us
        if routine.left_us <= 0:
            _put_aside(routine)


def wait_a_tick() -> None:
    """Puts the work aside until the next tick: there is nothing to do but to wait.

    Raises:
        RuntimeError: it is not done in slices.
    """
    routine = getcurrent()
    if not isinstance(routine, _Routine):
        raise RuntimeError("only work in slices can wait for a tick")
    _put_aside(routine)


def _put_aside(routine: _Routine) -> None:
    assert routine.parent is not None
    routine.parent.switch()


def ask_once(think: Callable[[], T]) -> T | None:
    """The answer to a question, if it can be thought over in a slice; else None."""
    thinking = InSlices(think)
    if thinking.step():
        return thinking.result
    thinking.abandon()
    return None


class Question(Generic[T]):
    """One question at a time, thought over in slices, a slice each time it is asked."""

    def __init__(self) -> None:
        self._about: object = None
        self._thinking: InSlices[T] | None = None

    def ask(self, about: object, think: Callable[[], T]) -> T | None:
        """The answer; None while it is not known.

        Args:
            about: what decides on the answer; another one makes another question of it.
            think: finds the answer, which is not None.
        """
        if self._thinking is None or self._about != about:
            self.abandon()
            self._about, self._thinking = about, InSlices(think)
        if not self._thinking.step():
            return None
        answer = self._thinking.result
        self.abandon()
        return answer

    @property
    def is_open(self) -> bool:
        """Whether it was asked, and not answered yet."""
        return self._thinking is not None

    def abandon(self) -> None:
        """It is not asked any more."""
        if self._thinking is not None:
            self._thinking.abandon()
            self._thinking = None
