"""A small validator of JSON Schema (draft 2020-12): the keywords that our schemas of lines use."""

from __future__ import annotations

import re
from typing import Any

TYPES: dict[str, tuple[type, ...]] = {
    "object": (dict,),
    "array": (list,),
    "string": (str,),
    "integer": (int,),
    "number": (int, float),
    "boolean": (bool,),
    "null": (type(None),),
}
KEYWORDS = {
    *("$schema", "$defs", "$ref", "title", "description", "anyOf", "const", "enum", "type"),
    *("properties", "required", "additionalProperties", "items", "prefixItems"),
    *("minItems", "maxItems", "minimum", "pattern"),
}


def is_valid(value: Any, schema: Any, root: dict[str, Any]) -> bool:
    """Whether a value is as a schema says.

    Args:
        root: the schema that has the definitions.
    """
    if isinstance(schema, bool):
        return schema
    assert schema.keys() <= KEYWORDS, "not known to this validator"
    if "$ref" in schema:
        return is_valid(value, root["$defs"][schema["$ref"].removeprefix("#/$defs/")], root)
    if "anyOf" in schema and not any(is_valid(value, each, root) for each in schema["anyOf"]):
        return False
    if "const" in schema and (value != schema["const"] or type(value) is not type(schema["const"])):
        return False
    if "enum" in schema and value not in schema["enum"]:
        return False
    if "type" in schema:
        is_boolean = isinstance(value, bool)
        if is_boolean is not (schema["type"] == "boolean"):
            return False
        if not isinstance(value, TYPES[schema["type"]]):
            return False
    if isinstance(value, str):
        return re.search(schema.get("pattern", ""), value) is not None
    if isinstance(value, dict):
        return _is_valid_object(value, schema, root)
    if isinstance(value, list):
        return _is_valid_array(value, schema, root)
    return not isinstance(value, int | float) or value >= schema.get("minimum", -float("inf"))


def _is_valid_object(value: dict[str, Any], schema: dict[str, Any], root: dict[str, Any]) -> bool:
    properties, others = schema.get("properties", {}), schema.get("additionalProperties", True)
    return set(schema.get("required", ())) <= value.keys() and all(
        is_valid(each, properties.get(key, others), root) for key, each in value.items()
    )


def _is_valid_array(value: list[Any], schema: dict[str, Any], root: dict[str, Any]) -> bool:
    if not schema.get("minItems", 0) <= len(value) <= schema.get("maxItems", len(value)):
        return False
    first = schema.get("prefixItems", [])
    rest = [schema.get("items", True)] * (len(value) - len(first))
    return all(is_valid(each, s, root) for each, s in zip(value, [*first, *rest], strict=False))
