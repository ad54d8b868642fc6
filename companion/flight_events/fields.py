"""Fields of events: how each is carried by a line of events.jsonl, and what it means.

A field is a key of the line's JSON object, by its own name, unless its type says otherwise:
`InText[...]` is carried by the text alone, the fields of an `Inline[...]` dataclass are keys
of the line themselves. A field that `__init__` does not take is constant for its class. A
`Doc` in the annotation is the field's meaning, as docs/run-folder.md has it.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from enum import Enum
from functools import cache
from typing import Annotated, Any, TypeVar, get_origin, get_type_hints

T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class Doc:
    """The meaning of a field, in Markdown."""

    text: str


class Carrier(Enum):
    """What carries a field's value on a line of events.jsonl."""

    KEY = "a key of its own"
    KEYS = "a key for each of its fields"
    TEXT = "the text"


InText = Annotated[T, Carrier.TEXT]
Inline = Annotated[T, Carrier.KEYS]


@dataclass(frozen=True, slots=True)
class EventField:
    """A field of an event, or of a dataclass within one.

    Attributes:
        type: its type, without annotations.
        is_constant: it has the value `constant` in all objects of its class.
    """

    name: str
    type: Any
    carrier: Carrier
    doc: str
    is_constant: bool
    constant: object


def fields_of(owner: type) -> tuple[EventField, ...]:
    """The fields of a dataclass, in the order of their keys."""
    return _declared(owner)


def keys_of(owner: type) -> tuple[EventField, ...]:
    """The fields that are keys, those of inline dataclasses included."""
    return _keys(owner)


@cache
def item_types(owner: type) -> tuple[Any, ...]:
    """The types of a named tuple's items."""
    return tuple(get_type_hints(owner).values())


@cache
def _keys(owner: type) -> tuple[EventField, ...]:
    found: list[EventField] = []
    for field in fields_of(owner):
        if field.carrier is Carrier.KEY:
            found.append(field)
        elif field.carrier is Carrier.KEYS:
            found += keys_of(field.type)
    return tuple(found)


@cache
def _declared(owner: type) -> tuple[EventField, ...]:
    hints = get_type_hints(owner, include_extras=True)
    return tuple(_field(each, hints[each.name]) for each in dataclasses.fields(owner))


def _field(declared: dataclasses.Field[Any], hint: Any) -> EventField:
    notes: tuple[object, ...] = ()
    if get_origin(hint) is Annotated:
        hint, notes = hint.__origin__, hint.__metadata__
    return EventField(
        name=declared.name,
        type=hint,
        carrier=next((note for note in notes if isinstance(note, Carrier)), Carrier.KEY),
        doc=next((note.text for note in notes if isinstance(note, Doc)), ""),
        is_constant=not declared.init,
        constant=declared.default,
    )
