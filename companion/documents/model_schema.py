"""Finds parts of a model's JSON Schema by the keys of a document."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from companion.errors import Keys

Schema = Mapping[str, Any]


def schema_at(root: Schema, keys: Keys) -> Schema:
    """The part of a JSON Schema that describes the value at some keys; {} if there is none."""
    schema = _unresolved(root, keys)
    resolved = _resolved(root, schema)
    return {**resolved, **{k: v for k, v in schema.items() if k == "description"}}


def alone(root: Schema, keys: Keys) -> str:
    """The plain value, without keys, that is allowed there, in words."""
    choices = (c for c in _unresolved(root, keys).get("anyOf", ()) if "$ref" not in c)
    return "".join(f", or {c['description']} alone" for c in choices if "description" in c)


def _unresolved(root: Schema, keys: Keys) -> Schema:
    schema = root
    for key in keys:
        schema = _step(_resolved(root, schema), key)
    return schema


def _step(schema: Schema, key: str | int) -> Schema:
    if isinstance(key, int):
        listed = schema.get("prefixItems", [])
        found = listed[key] if key < len(listed) else schema.get("items", {})
    else:
        by_name = schema.get("properties", {})
        of_any_name = [*schema.get("patternProperties", {}).values()]
        of_any_name.append(schema.get("additionalProperties", {}))
        found = by_name.get(key, of_any_name[0])
    return found if isinstance(found, dict) else {}


def _resolved(root: Schema, schema: Schema) -> Schema:
    """Follows a reference; among alternatives, to the one that is a mapping or list."""
    for choice in schema.get("anyOf", ()):
        if {"$ref", "items", "properties"} & choice.keys():
            return _resolved(root, choice)
    if "$ref" in schema:
        found: Schema = root["$defs"][schema["$ref"].rsplit("/", 1)[1]]
        return found
    return schema
