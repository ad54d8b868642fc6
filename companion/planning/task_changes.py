"""The changes of a task's state, as data: repeated on the first state, they give the same state.

`recorded` and `recorded_where` mark the methods of `TaskState` that change it. Each call from
outside is reported with its arguments, as names. task_replay.py makes the same calls on another
state of the same mission. So no state has to be written down, and no part of it can be forgotten.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import wraps
from typing import Any, Concatenate, ParamSpec, Protocol, TypeVar

from companion.mission.model import Event
from companion.planning.domain import Action

Argument = str | float | bool | None | tuple[str, ...]
"""A name, a number, or several names."""


@dataclass(frozen=True, slots=True)
class TaskChange:
    """One call that changed a task's state.

    Attributes:
        method: the method of `TaskState`.
        arguments: actions, events and facts by their names.
        positions: how many positions of the word had been left after the call.
        now_s: the time of the call; 0 if the task has no clocks.
    """

    method: str
    arguments: tuple[Argument, ...]
    positions: int = 0
    now_s: float = 0.0


class Recorded(Protocol):
    """A class with recorded methods.

    Attributes:
        positions: how many positions of the word have been left.
        now_s: the time; only kept if the task has clocks.
        is_changing: whether a change is under way.
        on_change: called with each change, after it.
    """

    positions: int
    now_s: float
    is_changing: bool
    on_change: Callable[[TaskChange], None]


P = ParamSpec("P")
R = TypeVar("R")
S = TypeVar("S", bound=Recorded)


def recorded(
    method: Callable[Concatenate[S, P], R],
) -> Callable[Concatenate[S, P], R]:
    """Marks a method that changes the state; calls within it belong to the same change."""
    return recorded_where(lambda _: True)(method)


def recorded_where(
    has_changed: Callable[[Any], bool],
) -> Callable[[Callable[Concatenate[S, P], R]], Callable[Concatenate[S, P], R]]:
    """The same for a method that may leave the state unchanged, as its result tells."""

    def of(method: Callable[Concatenate[S, P], R]) -> Callable[Concatenate[S, P], R]:
        @wraps(method)
        def call(state: S, /, *arguments: P.args, **options: P.kwargs) -> R:
            if state.is_changing:
                return method(state, *arguments, **options)
            state.is_changing = True
            try:
                done = method(state, *arguments, **options)
            finally:
                state.is_changing = False
            if has_changed(done):
                named = tuple(map(_named, (*arguments, *options.values())))
                state.on_change(TaskChange(method.__name__, named, state.positions, state.now_s))
            return done

        return call

    return of


def _named(argument: object) -> Argument:
    match argument:
        case Action() | Event():
            return argument.name
        case None | bool() | int() | float() | str():
            return argument
        case Iterable():
            return tuple(sorted(str(_named(each)) for each in argument))
    raise TypeError(f"{argument!r} has no name")
