"""What the lines of events.jsonl may be: their JSON Schema, and the tables of docs/run-folder.md.

Both are generated from the classes of the events, by scripts/make_schema.py, and checked in.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from enum import Enum
from types import NoneType, UnionType
from typing import Any, Literal, get_args, get_origin

from companion.flight_events.catalogue import RECORDED
from companion.flight_events.event import FlightEvent
from companion.flight_events.event_fields import fields_of, item_types

Schema = dict[str, Any]
SCALARS = {str: "string", int: "integer", float: "number", bool: "boolean", NoneType: "null"}


# -- JSON Schema -----------------------------------------------------------------------------------


def json_schema() -> Schema:
    """The JSON Schema (draft 2020-12) of a line of events.jsonl: any of the classes of events."""
    definitions: dict[str, Schema] = {}
    for event in RECORDED:
        definitions[event.__name__] = _event(event, definitions)
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "FlightEvent",
        "description": "A line of events.jsonl: `type` says which of these it is.",
        "anyOf": [{"$ref": f"#/$defs/{event.__name__}"} for event in RECORDED],
        "$defs": definitions,
    }


def _event(event: type[FlightEvent], definitions: dict[str, Schema]) -> Schema:
    about: dict[str, Schema] = {
        "t_s": {"type": "number", "minimum": 0, "description": "Seconds since the run began."},
        "type": {"const": event.__name__},
        "kind": {"const": event.kind},
        "text": {"type": "string", "description": "For people, and not read by programs."},
    }
    return {"description": _summary(event)} | _object(about | _keys(event, definitions))


def _object(properties: dict[str, Schema]) -> Schema:
    return {
        "type": "object",
        "properties": properties,
        "required": list(properties),
        "additionalProperties": False,
    }


def _keys(owner: type, definitions: dict[str, Schema]) -> dict[str, Schema]:
    return {
        field.name: _type(field.type, definitions) | {"description": field.doc}
        for field in fields_of(owner)
    }


def _type(type_: Any, definitions: dict[str, Schema]) -> Schema:
    origin, arguments = get_origin(type_), get_args(type_)
    if type_ in SCALARS:
        return {"type": SCALARS[type_]}
    if origin is Literal:
        return {"enum": list(arguments)}
    if origin is UnionType:
        return {"anyOf": [_type(each, definitions) for each in arguments]}
    if origin is tuple:
        return _array(arguments, definitions)
    if origin is Mapping:
        return {"type": "object", "additionalProperties": _type(arguments[1], definitions)}
    if issubclass(type_, Enum):
        return {"enum": [member.value for member in type_]}
    if issubclass(type_, tuple):
        return _array(item_types(type_), definitions)
    return _reference(type_, definitions)


def _reference(owner: type, definitions: dict[str, Schema]) -> Schema:
    """A reference to a dataclass, which is defined by its first use."""
    if owner.__name__ not in definitions:
        about = {"description": _summary(owner)}
        definitions[owner.__name__] = about | _object(_keys(owner, definitions))
    return {"$ref": f"#/$defs/{owner.__name__}"}


def _array(types: tuple[Any, ...], definitions: dict[str, Schema]) -> Schema:
    if types[-1] is Ellipsis:
        return {"type": "array", "items": _type(types[0], definitions)}
    items = [_type(each, definitions) for each in types]
    return {"type": "array", "prefixItems": items, "items": False, "minItems": len(items)}


# -- tables of docs/run-folder.md ------------------------------------------------------------------


def with_tables(page: str) -> str:
    """A page with its tables made anew; each stands between two comments that name it."""
    for name, table in {"kinds": kinds_table, "fields": fields_table}.items():
        before, opening, rest = page.partition(f"<!-- generated: {name} of events -->\n")
        _, closing, after = rest.partition("<!-- end -->\n")
        page = f"{before}{opening}\n{table()}\n{closing}{after}"
    return page


def kinds_table() -> str:
    """A row for each class: its kind, its text, its other keys, and what happened."""
    rows = []
    for event in RECORDED:
        summary = _summary(event).removesuffix(".")
        what = summary[0].lower() + summary[1:]
        rows.append(
            (
                f"`{event.__name__}`",
                f"`{event.kind}`",
                f"`{_plain(event.template)}`",
                ", ".join(f"`{field.name}`" for field in fields_of(event)),
                what if event.is_told else f"{what}; not printed in flight",
            )
        )
    return _table(("`type`", "`kind`", "`text`", "other keys", "what happened"), rows)


def fields_table() -> str:
    """A row for each meaning that a key may have."""
    types: dict[tuple[str, str], dict[str, None]] = {}
    for event in RECORDED:
        for field in fields_of(event):
            types.setdefault((field.name, field.doc), {})[f"`{event.__name__}`"] = None
    names = [name for name, _ in types]
    meanings: dict[str, list[str]] = {}
    for (name, doc), of in types.items():
        where = f" of {', '.join(of)}" if names.count(name) > 1 else ""
        meanings.setdefault(doc, []).append(f"`{name}`{where}")
    rows = [(", ".join(fields), doc) for doc, fields in meanings.items()]
    return _table(("field", "content"), rows)


def _table(head: tuple[str, ...], rows: Iterable[tuple[str, ...]]) -> str:
    lines = [head, ("---",) * len(head), *rows]
    return "".join(f"| {' | '.join(cells)} |\n".replace("|  |", "| |") for cells in lines)


def _plain(template: str) -> str:
    """A template without the formats of its numbers."""
    return re.sub(r"\{(\w+):[^}]*\}", r"{\1}", template)


def _summary(owner: type) -> str:
    """The first sentence of a class."""
    return (owner.__doc__ or "").partition("\n")[0]
