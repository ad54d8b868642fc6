"""What the lines of events.jsonl may be: their JSON Schema, and the tables of docs/run-folder.md.

Both are generated from the classes of the events, by scripts/make_schema.py, and checked in.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from enum import Enum
from string import Formatter
from types import NoneType, UnionType
from typing import Any, get_args, get_origin

from companion.flight_events.catalogue import RECORDED
from companion.flight_events.event import FlightEvent
from companion.flight_events.fields import Carrier, EventField, fields_of, item_types, keys_of

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
        "description": "A line of events.jsonl. Classes may share a kind: they are told apart by "
        "their keys, or by their text.",
        "anyOf": [{"$ref": f"#/$defs/{event.__name__}"} for event in RECORDED],
        "$defs": definitions,
    }


def _event(event: type[FlightEvent], definitions: dict[str, Schema]) -> Schema:
    about: dict[str, Schema] = {
        "t_s": {"type": "number", "minimum": 0, "description": "Seconds since the run began."},
        "kind": {"const": event.kind},
        "text": {"type": "string", "description": f"For people: {_plain(event.template)}"},
    }
    if pattern := _pattern(event):
        about["text"]["pattern"] = pattern
    return {"description": _summary(event)} | _object(about | _keys(event, definitions))


def _object(properties: dict[str, Schema]) -> Schema:
    return {
        "type": "object",
        "properties": properties,
        "required": list(properties),
        "additionalProperties": False,
    }


def _keys(owner: type, definitions: dict[str, Schema]) -> dict[str, Schema]:
    return {field.name: _key(field, definitions) for field in keys_of(owner)}


def _key(field: EventField, definitions: dict[str, Schema]) -> Schema:
    if field.is_constant:
        empty = {"type": "array", "maxItems": 0}
        schema = empty if field.constant == () else {"const": field.constant}
    else:
        schema = _type(field.type, definitions)
    return schema | {"description": field.doc}


def _type(type_: Any, definitions: dict[str, Schema]) -> Schema:
    origin, arguments = get_origin(type_), get_args(type_)
    if type_ in SCALARS:
        return {"type": SCALARS[type_]}
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


def _pattern(event: type[FlightEvent]) -> str:
    """A regular expression (ECMA-262) for the text, where it tells more than the keys do."""
    keys = [field.name for field in keys_of(event)]
    alike = [
        other
        for other in RECORDED
        if other.kind == event.kind and [field.name for field in keys_of(other)] == keys
    ]
    has_more = any(field.carrier is Carrier.TEXT for field in fields_of(event))
    if not has_more and len(alike) == 1:
        return ""
    special = r"([\\^$.|?*+()\[\]{}])"
    parts = [
        re.sub(special, r"\\\1", literal) + (_alternatives(event, name) if name else "")
        for literal, name, _, _ in Formatter().parse(event.template)
    ]
    return f"^{''.join(parts)}$"


def _alternatives(event: type[FlightEvent], name: str) -> str:
    type_ = next((field.type for field in fields_of(event) if field.name == name), str)
    if isinstance(type_, type) and issubclass(type_, Enum):
        return f"({'|'.join(str(member.value) for member in type_)})"
    return "-?[0-9]+" if type_ is int else r"[\s\S]*"


# -- tables of docs/run-folder.md ------------------------------------------------------------------


def with_tables(page: str) -> str:
    """A page with its tables made anew; each stands between two comments that name it."""
    for name, table in {"kinds": kinds_table, "fields": fields_table}.items():
        before, opening, rest = page.partition(f"<!-- generated: {name} of events -->\n")
        _, closing, after = rest.partition("<!-- end -->\n")
        page = f"{before}{opening}\n{table()}\n{closing}{after}"
    return page


def kinds_table() -> str:
    """A row for each class: its kind, its text, its fields, and what happened."""
    rows = []
    for event in RECORDED:
        keys = [f"`{field.name}`" for field in keys_of(event)]
        spoken = [f"`{f.name}`" for f in fields_of(event) if f.carrier is Carrier.TEXT]
        if spoken:
            keys.append(f"*{', '.join(spoken)}*")
        summary = _summary(event).removesuffix(".")
        what = summary[0].lower() + summary[1:]
        rows.append(
            (
                f"`{event.kind}`",
                f"`{event.__name__}`",
                f"`{_plain(event.template)}`",
                ", ".join(keys),
                what if event.is_told else f"{what}; not printed in flight",
            )
        )
    return _table(("kind", "class", "`text`", "fields", "what happened"), rows)


def fields_table() -> str:
    """A row for each meaning that a key may have."""
    kinds: dict[tuple[str, str], dict[str, None]] = {}
    for event in RECORDED:
        for field in keys_of(event):
            kinds.setdefault((field.name, field.doc), {})[f"`{event.kind}`"] = None
    names = [name for name, _ in kinds]
    meanings: dict[str, list[str]] = {}
    for (name, doc), of in kinds.items():
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
