"""Fields of events, as their classes declare them.

A field is a key on the event's line of events.jsonl, by its own name. A `Doc` in its annotation is
its meaning, as docs/run-folder.md has it.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from functools import cache
from typing import Annotated, Any, get_origin, get_type_hints


@dataclass(frozen=True, slots=True)
class Doc:
    """The meaning of a field, in Markdown."""

    text: str


Reason = Annotated[str, Doc("why, in words")]


@dataclass(frozen=True, slots=True)
class EventField:
    """A field of an event, or of a dataclass within one.

    Attributes:
        type: its type, without annotations.
    """

    name: str
    type: Any
    doc: str


def fields_of(owner: type) -> tuple[EventField, ...]:
    """Returns the fields of a dataclass, in the order of their keys."""
    return _declared(owner)


@cache
def item_types(owner: type) -> tuple[Any, ...]:
    """Returns the types of a named tuple's items."""
    return tuple(get_type_hints(owner).values())


@cache
def _declared(owner: type) -> tuple[EventField, ...]:
    hints = get_type_hints(owner, include_extras=True)
    return tuple(_field(each.name, hints[each.name]) for each in dataclasses.fields(owner))


def _field(name: str, hint: Any) -> EventField:
    if get_origin(hint) is not Annotated:
        return EventField(name, hint, doc="")
    doc = next((note.text for note in hint.__metadata__ if isinstance(note, Doc)), "")
    return EventField(name, hint.__origin__, doc)
