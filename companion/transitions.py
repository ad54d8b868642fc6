"""State machines as tables: the next state for each state and event, and the effect.

The states of a machine are one enum and its events another; each row of its table is one
transition. The code looks up the next state in the table, and the documentation's diagrams are
drawn from the same rows (scripts/make_diagrams.py). A state without a row of its own is final.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from enum import Enum
from typing import Generic, TypeVar

S = TypeVar("S", bound=Enum)
E = TypeVar("E", bound=Enum)


@dataclass(frozen=True, slots=True)
class StateTransition(Generic[S, E]):
    """One row of a table.

    Attributes:
        state: before the event; None before the machine exists.
        event: what happens.
        then: the next state.
        effect: what is done in the transition, in words.
    """

    state: S | None
    event: E
    then: S
    effect: str


class TransitionTable(Generic[S, E]):
    """The transitions of one machine.

    >>> class Door(Enum):
    ...     OPEN = "open"
    ...     SHUT = "shut"
    >>> class Push(Enum):
    ...     PUSHED = "pushed"
    >>> row = StateTransition(Door.OPEN, Push.PUSHED, Door.SHUT, "the bell rings")
    >>> table = TransitionTable(row)
    >>> table.next(Door.OPEN, Push.PUSHED)
    <Door.SHUT: 'shut'>
    >>> table.next(Door.SHUT, Push.PUSHED)
    Traceback (most recent call last):
    ...
    ValueError: no transition from shut on pushed

    Raises:
        ValueError: two rows have the same state and event.
    """

    def __init__(self, *transitions: StateTransition[S, E]) -> None:
        self._rows = {(row.state, row.event): row for row in transitions}
        if len(self._rows) < len(transitions):
            raise ValueError("two transitions have the same state and event")

    def __iter__(self) -> Iterator[StateTransition[S, E]]:
        return iter(self._rows.values())

    def next(self, state: S | None, event: E) -> S:
        """The next state after an event.

        Raises:
            ValueError: the event cannot occur in this state.
        """
        row = self._rows.get((state, event))
        if row is None:
            before = "the beginning" if state is None else state.value
            raise ValueError(f"no transition from {before} on {event.value}")
        return row.then

    def is_final(self, state: S) -> bool:
        """Whether no event leads away from a state."""
        return all(before is not state for before, _ in self._rows)
