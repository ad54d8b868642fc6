"""Events of a flight: plain facts, a frozen dataclass of its own for each kind.

What a class declares is all there is to say about its kind; everything else derives from it: the
text for people, the lines of events.jsonl (writing.py, reading.py), their JSON Schema and the
tables of docs/run-folder.md (description.py). catalogue.py lists the classes. An event does not
know when it happened; `Stamped` says so beside it.

On a line, `type` is the class. The `kind` is a group of classes that people filter by, and the text
is for people: nothing is read out of either.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import Any, ClassVar


class FlightEvent:
    """Something that happened in a flight.

    Attributes:
        kind: the group that it belongs to; several classes may share it.
        template: the text for people, with attributes of the event in braces.
        is_told: the event is news for people, not for programs alone.
        is_recorded: events.jsonl keeps it.
    """

    __slots__ = ()
    kind: ClassVar[str]
    template: ClassVar[str]
    is_told: ClassVar[bool] = True
    is_recorded: ClassVar[bool] = True

    @property
    def text(self) -> str:
        """The event in words, for people; it may have several lines."""
        return self.template.format_map(_Attributes(self))


@dataclass(frozen=True, slots=True)
class Stamped:
    """An event and the time at which it happened.

    Attributes:
        time_s: seconds since the run began.
    """

    time_s: float
    event: FlightEvent


class _Attributes:
    """The attributes of an object by name; of an enum its value."""

    def __init__(self, owner: object) -> None:
        self._owner = owner

    def __getitem__(self, name: str) -> Any:
        value = getattr(self._owner, name)
        return value.value if isinstance(value, Enum) else value
