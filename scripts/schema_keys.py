"""The keys of files that people write, read from the JSON schemas of their models."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import Any, NamedTuple

Schema = Mapping[str, Any]


class KeyTable(NamedTuple):
    """A mapping in a file: its path and its model."""

    path: str
    model: str
    schema: Schema


def inlined(schema: Any, definitions: Schema | None = None) -> Any:
    """A schema with enumerations in place, and without null for what may be absent."""
    definitions = schema.get("$defs", {}) if definitions is None else definitions
    match schema:
        case {"$ref": str(), **rest} if "properties" not in definitions[name_of(schema)]:
            return {**definitions[name_of(schema)], **rest}
        case {"anyOf": [*kinds, {"type": "null"}], **rest}:
            one = kinds[0] if len(kinds) == 1 else {"anyOf": kinds}
            return {**inlined(one, definitions), **rest}
        case dict():
            return {key: inlined(value, definitions) for key, value in schema.items()}
        case list():
            return [inlined(value, definitions) for value in schema]
    return schema


def tables(schema: Schema, root: str) -> list[KeyTable]:
    """The mappings of a file, each once, in the order of the keys that lead to them."""
    found = [KeyTable("", root, schema)]
    known = {root}
    for table in found:  # grows in the loop
        for key, value in table.schema["properties"].items():
            for model, ending in references(value):
                if model not in known:
                    known.add(model)
                    path = f"{table.path}.{key}".lstrip(".") + ending
                    found.append(KeyTable(path, model, schema["$defs"][model]))
    return found


def references(value: Schema, ending: str = "") -> Iterator[tuple[str, str]]:
    """The models that a value may have, each with the continuation of its path."""
    if "$ref" in value:
        yield name_of(value), ending
    for inner in value.get("anyOf", []):
        yield from references(inner, ending)
    if isinstance(value.get("items"), dict):
        yield from references(value["items"], ending + "[]")
    if (inner := named(value)) is not None:
        yield from references(inner, ending + ".NAME")


def named(value: Schema) -> Schema | None:
    """The schema of the entries, if a value is a mapping from names."""
    inner = value.get("additionalProperties")
    if isinstance(inner, dict):
        return inner
    return next(iter(value.get("patternProperties", {}).values()), None)


def name_of(reference: Schema) -> str:
    """The model to which a reference points."""
    return str(reference["$ref"]).rpartition("/")[2]


def values(content: Any, table: KeyTable, schema: Schema) -> Iterator[tuple[tuple[str, str], Any]]:
    """All values of a file by model and key."""
    for key, value in content.items():
        if key not in table.schema["properties"]:
            continue
        yield (table.model, key), value
        for model, ending in references(table.schema["properties"][key]):
            definition = schema["$defs"][model]
            inner = KeyTable("", model, definition)
            for each in _reached(value, ending):
                if isinstance(each, dict) and "properties" in definition:
                    yield from values(each, inner, schema)


def _reached(value: Any, ending: str) -> Iterable[Any]:
    """The values at the end of a path that begins at a value."""
    if ending.endswith((".NAME", "[]")) and isinstance(value, dict | list):
        return value.values() if isinstance(value, dict) else value
    return [] if ending else [value]
