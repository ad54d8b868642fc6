"""Finds what can be read of a document with mistakes, and which of its keys remain unread.

1. An invalid value is removed. If the rest is then incomplete, a stand-in replaces the value, or
   the part around it is removed too.
2. A stand-in has no meaning: it keeps a name known and a model complete. Later readers ask whether
   a value is unread before they look at it (reading.py).
3. An invalid key removes only its own value. It is remembered that there is more than could be
   read, so that no other name is called unknown.
4. An unknown key counts as a misspelling of the key that it resembles, or of any absent one.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping
from copy import deepcopy
from typing import Any, TypeVar

from pydantic import BaseModel, ValidationError

from companion.documents.diagnostics import NO_NAME, Detail, existing_keys, meant_key
from companion.documents.model_schema import Schema, schema_at
from companion.errors import Keys

StandIns = Mapping[Keys, object]
"""Keys, `*` for any -> what to read there in place of an unread value."""

M = TypeVar("M", bound=BaseModel)

_ROUNDS = 8  # each round removes what lacks a removed value; files nest 5 deep


def strictly(model: type[M], data: object) -> M:
    """Plain values as the model, strictly: a text is not a number.

    Raises:
        ValidationError: they do not fit.
    """
    return model.model_validate_json(json.dumps(data), strict=True)


def without(data: object, refused: Iterable[Keys], stand_ins: StandIns) -> tuple[object, set[Keys]]:
    """Plain values without some of them, with stand-ins in their place; and the removed keys."""
    data, unread = deepcopy(data), {_whole(keys) for keys in refused}
    for keys in unread:
        _take_out(data, keys, stand_ins)
    return data, unread


def what_is_readable(
    model: type[M], data: object, error: ValidationError, stand_ins: StandIns
) -> tuple[M, set[Keys]] | None:
    """The rest of a document, and the keys of what is unread; None if nothing can be read.

    Args:
        model: the model of the document.
        data: as plain values.
        error: why it does not fit the model.
        stand_ins: for parts that the model needs.
    """
    data, unread, schema = deepcopy(data), set[Keys](), model.model_json_schema()
    for _ in range(_ROUNDS):
        details = [
            (existing_keys(each["loc"], data), dict(each))
            for each in error.errors(include_url=False)
        ]
        details.sort(
            key=lambda each: each[1]["type"] != "extra_forbidden"
        )  # before those that are missing
        for keys, detail in details:
            for wrong in _useless(keys, detail, schema, data, stand_ins):
                unread.add(wrong)
                if not _take_out(data, wrong, stand_ins):
                    return None
        try:
            return strictly(model, data), unread
        except ValidationError as again:
            error = again
    return None


def _useless(
    keys: Keys, detail: Detail, schema: Schema, data: object, stand_ins: StandIns
) -> Iterator[Keys]:
    """The keys of the values that one mistake makes useless."""
    kind, name = detail["type"], detail["loc"][-1] if detail["loc"] else ""
    if _whole(keys) != keys:
        yield _whole(keys)
    elif kind == "missing":
        needed = (*keys, name)
        yield needed if _stand_in(needed, stand_ins) is not None else keys
    elif kind == "extra_forbidden":
        parent = _at(data, keys[:-1])
        parent.pop(keys[-1], None)
        known = schema_at(schema, keys[:-1]).get("properties", ())
        absent = [key for key in known if key not in parent]
        meant = meant_key(str(keys[-1]), absent)
        yield from ((*keys[:-1], key) for key in ([meant] if meant else absent))
    elif name == NO_NAME:
        _at(data, keys[:-1]).pop(keys[-1], None)
        yield (*keys[:-1], NO_NAME)
    else:
        yield keys


def _whole(keys: Keys) -> Keys:
    """The list for an item of a list, because removal would renumber the others; else the same."""
    indices = [i for i, key in enumerate(keys) if isinstance(key, int)]
    return keys[: indices[0]] if indices else keys


def _take_out(data: object, keys: Keys, stand_ins: StandIns) -> bool:
    """Removes a value, or replaces it by its stand-in; False if nothing would be left."""
    if not keys or not isinstance(data, dict):
        return False
    parent = _at(data, keys[:-1])
    if isinstance(parent, dict) and keys[-1] != NO_NAME:
        stand_in = _stand_in(keys, stand_ins)
        if stand_in is None:
            parent.pop(keys[-1], None)
        else:
            parent[keys[-1]] = deepcopy(stand_in)
    return True


def _stand_in(keys: Keys, stand_ins: StandIns) -> object:
    return next(
        (
            value
            for pattern, value in stand_ins.items()
            if len(pattern) == len(keys)
            and all(wanted in ("*", key) for wanted, key in zip(pattern, keys, strict=True))
        ),
        None,
    )


def _at(data: object, keys: Keys) -> Any:
    """The value at some keys; an empty mapping where it was removed."""
    for key in keys:
        data = data.get(key, {}) if isinstance(data, dict) else {}
    return data
