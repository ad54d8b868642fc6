"""Reads untrusted JSON: size and depth are limited, and values are requested by their type."""

from __future__ import annotations

import json
import math
from collections import Counter
from typing import Any, NoReturn

from companion.plans.route_plan import ItemRefused

MAX_DEPTH = 40
"""A plan of QGroundControl nests 8 deep, GeoJSON 9."""


def read_json(text: str) -> dict[str, Any]:
    """The JSON object in a text.

    Raises:
        ItemRefused: it is no object, nests too deep, has a key twice, or a number that is not
            finite.
    """
    if _depth(text) > MAX_DEPTH:
        raise ItemRefused("", f"nests deeper than {MAX_DEPTH} levels", "is this the right file?")
    try:
        data = json.loads(text, object_pairs_hook=_object, parse_constant=_not_finite)
    except json.JSONDecodeError as error:
        where = f"line {error.lineno}, column {error.colno}"
        raise ItemRefused("", f"is not JSON: {error.msg}, {where}", "save the file again") from None
    except (ValueError, RecursionError):  # such as a number of thousands of digits
        raise ItemRefused("", "is not JSON that can be read", "save the file again") from None
    if not isinstance(data, dict):
        raise ItemRefused("", "is JSON, but no object", "is this the right file?")
    return data


def _depth(text: str) -> int:
    """The deepest nesting; brackets in texts, of which there are few, count too."""
    depth = deepest = 0
    for character in text:
        if character in "[{":
            depth += 1
            deepest = max(deepest, depth)
        elif character in "]}":
            depth -= 1
    return deepest


def _object(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    found = dict(pairs)
    if len(found) < len(pairs):
        times = Counter(name for name, _ in pairs)
        twice = next(name for name in times if times[name] > 1)
        raise ItemRefused("", f"has the key {twice[:40]!r} twice in one object", "remove one")
    return found


def _not_finite(word: str) -> NoReturn:
    raise ItemRefused("", f"has the number {word}, which JSON does not know", "save it anew")


class JsonObject:
    """A JSON object whose values are requested by their type.

    Args:
        data: the value.
        item: its name in messages.

    Raises:
        ItemRefused: it is no object; in each method, the value is missing or of another type.
    """

    def __init__(self, data: object, item: str) -> None:
        if not isinstance(data, dict):
            raise ItemRefused(item, "is not an object", "save the file again")
        self.data: dict[str, Any] = data
        self.item = item

    def __contains__(self, key: str) -> bool:
        return self.data.get(key) is not None

    def number(self, key: str) -> float:
        """A finite number."""
        return number(self.data.get(key), self.item, key)

    def integer(self, key: str) -> int:
        """A whole number."""
        value = self.number(key)
        if value != int(value):
            raise ItemRefused(self.item, f"{key} is {value:g}, expected a whole number")
        return int(value)

    def text(self, key: str) -> str:
        """A text."""
        value = self._present(key)
        if not isinstance(value, str):
            raise ItemRefused(self.item, f"{key} is not a text", "save the file again")
        return value

    def flag(self, key: str) -> bool:
        """True or false."""
        value = self._present(key)
        if not isinstance(value, bool):
            raise ItemRefused(self.item, f"{key} is not true or false", "save the file again")
        return value

    def object(self, key: str) -> JsonObject:
        """An object in the object."""
        return JsonObject(self._present(key), f"{self.item}, {key}" if self.item else key)

    def list(self, key: str) -> list[Any]:
        """A list."""
        value = self._present(key)
        if not isinstance(value, list):
            raise ItemRefused(self.item, f"{key} is not a list", "save the file again")
        return value

    def _present(self, key: str) -> Any:
        if key not in self:
            raise ItemRefused(self.item, f"has no {key}", "save the file again")
        return self.data[key]


def number(value: object, item: str, name: str) -> float:
    """A finite number.

    Raises:
        ItemRefused: it is something else.
    """
    if isinstance(value, bool) or not isinstance(value, int | float):
        what = f"{name} is missing" if value is None else f"{name} is not a number"
        raise ItemRefused(item, what, "save the file again")
    try:
        found = float(value)
    except OverflowError:
        found = math.inf
    if not math.isfinite(found):
        raise ItemRefused(item, f"{name} is too large")
    return found


def numbers(value: object, item: str, name: str, least: int) -> list[float]:
    """A list of at least `least` numbers.

    Raises:
        ItemRefused: it is something else.
    """
    if not isinstance(value, list) or len(value) < least:
        raise ItemRefused(item, f"{name} is not a list of {least} numbers", "save the file again")
    return [number(each, item, name) for each in value]
