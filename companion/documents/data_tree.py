"""Python values as a tree, in which every key and value knows its path of keys.

Allowed is what YAML can express: mappings with texts as keys, lists and tuples, texts, paths,
finite numbers (numpy's too), true and false, and None.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from numbers import Integral, Real

from companion.documents.yaml_tree import (
    MAX_DEPTH,
    MappingEntry,
    MappingNode,
    Node,
    ScalarNode,
    SequenceNode,
    Value,
)
from companion.errors import KeyPath, Keys, MissionError


def tree_of(data: object, keys: Keys = ()) -> Node:
    """Returns the tree of a value.

    Args:
        data: the value.
        keys: the path that leads to it.

    Raises:
        MissionError: too deep, or something that YAML cannot express.
    """
    where = KeyPath(keys)
    if len(keys) >= MAX_DEPTH:
        raise MissionError(f"nested deeper than {MAX_DEPTH} levels", where)
    if isinstance(data, Mapping):
        entries = {}
        for key, value in data.items():
            if not isinstance(key, str):
                raise MissionError(f"the key {key!r} is not a text", where)
            inner = (*keys, key)
            entries[key] = MappingEntry(KeyPath(inner), tree_of(value, inner))
        return MappingNode(where, entries)
    if isinstance(data, list | tuple):
        return SequenceNode(where, tuple(tree_of(item, (*keys, i)) for i, item in enumerate(data)))
    return ScalarNode(where, _scalar(data, where), 0, 0)


def _scalar(value: object, where: KeyPath) -> Value:
    if value is None or isinstance(value, bool | str):
        return value
    if hasattr(value, "__fspath__"):  # a path
        return str(value)
    if isinstance(value, Integral):
        return int(value)
    if isinstance(value, Real):
        if not math.isfinite(value):
            raise MissionError(f"{value} is not a finite number", where)
        return float(value)
    raise MissionError(
        f"a value of type {type(value).__name__} cannot stand here",
        where,
        "use texts, numbers, True, False, None, lists and dicts",
    )
