"""Does long work in slices, between which setpoints are sent.

1. A flight plans in the loop that sends its setpoints. So planning works in slices. Wherever it
   takes long it calls `spent`, with the approximate duration of the last steps. When these add up
   to a slice, the work is suspended wherever it is, until the next tick.
2. The times are rated and counted, not measured: equal flights have equal slices on every machine.
3. Work in slices is a coroutine (greenlet), so the functions between need not know of it.
4. Other code runs only during `spent`. Work that reads data which may change there makes a copy
   before.
5. Outside of slices `spent` does nothing, and work runs without interruption.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Generic, TypeVar
from weakref import WeakSet

from greenlet import getcurrent, greenlet

SLICE_US = 8_000
"""Rated work of a tick; slower machines take longer, and two slices must leave time in a tick."""

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
        work: what to do; `step` raises its exceptions.
        slice_us: rated work of a step; None means `SLICE_US`.
    """

    def __init__(self, work: Callable[[], T], slice_us: float | None = None) -> None:
        self._routine = _Routine(self._run)
        _UNDER_WAY.add(self._routine)
        self._work = work
        self._slice_us = slice_us

    def _run(self) -> None:
        self.result = self._work()

    def step(self) -> bool:
        """Works for one slice; returns whether the work is done."""
        if not self._routine.dead:
            self._routine.left_us = self._slice_us or SLICE_US
            self._routine.parent = getcurrent()
            self._routine.switch()
        return self._routine.dead

    def abandon(self) -> None:
        """Ends the work where it was suspended."""
        if not self._routine.dead:
            self._routine.throw()


class _Routine(greenlet):
    """The coroutine of some work.

    left_us: rest of the slice.
    """

    left_us: float = 0.0


_UNDER_WAY: WeakSet[_Routine] = WeakSet()


def abandon_all() -> None:
    """Ends all suspended work that was begun from this coroutine, at the end of a flight.

    The garbage collection does not reach suspended work: at exit, all that it refers to would
    remain, and libraries in C++ would report this on standard error.

    >>> adding = InSlices(lambda: spent(9_000))
    >>> adding.step(), abandon_all(), adding.step()
    (False, None, True)
    """
    here = getcurrent()
    for routine in [*_UNDER_WAY]:
        if not routine.dead and routine.parent is here:
            routine.throw()


def spent(work_us: float) -> None:
    """States how long the last steps took, about; suspends the work at the end of a slice."""
    routine = getcurrent()
    if isinstance(routine, _Routine):
        routine.left_us -= work_us
        if routine.left_us <= 0:
            _put_aside(routine)


def wait_a_tick() -> None:
    """Suspends the work until the next tick, because it has to wait.

    Raises:
        RuntimeError: the work is not done in slices.
    """
    routine = getcurrent()
    if not isinstance(routine, _Routine):
        raise RuntimeError("only work in slices can wait for a tick")
    _put_aside(routine)


def _put_aside(routine: _Routine) -> None:
    assert routine.parent is not None
    routine.parent.switch()


def ask_once(think: Callable[[], T]) -> T | None:
    """The answer to a question, if one slice is enough; otherwise None."""
    thinking = InSlices(think)
    if thinking.step():
        return thinking.result
    thinking.abandon()
    return None


@dataclass(frozen=True, slots=True)
class Answered(Generic[T]):
    """The answer to a question, which may be None."""

    answer: T


class Question(Generic[T]):
    """One question at a time, whose answer is found in slices, one at each call."""

    def __init__(self) -> None:
        self._about: object = None
        self._thinking: InSlices[T] | None = None

    def ask(self, about: object, think: Callable[[], T]) -> Answered[T] | None:
        """The answer; None while it is unknown.

        Args:
            about: what the answer depends on; another value begins another question.
            think: finds the answer.
        """
        if self._thinking is None or self._about != about:
            self.abandon()
            self._about, self._thinking = about, InSlices(think)
        if not self._thinking.step():
            return None
        answered = Answered(self._thinking.result)
        self.abandon()
        return answered

    @property
    def is_open(self) -> bool:
        """Whether a question was asked and not answered yet."""
        return self._thinking is not None

    def abandon(self) -> None:
        """Drops the question."""
        if self._thinking is not None:
            self._thinking.abandon()
            self._thinking = None
