"""Values of JSON as values of a type: strict, without conversions but those of JSON itself.

Types are those that fields of events have: str, int, float, bool, None, literals, enums, tuples of
one type or of several, mappings from str, dataclasses, named tuples, and unions of these. What
reads a type is made once for each.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from enum import Enum
from functools import cache, partial
from types import NoneType, UnionType
from typing import Any, Literal, get_args, get_origin

from companion.flight_events.event_fields import fields_of, item_types

_SCALARS = (str, int, bool, NoneType)
_Reader = Callable[[Any], Any]


class Unfit(Exception):
    """A value is not of its type."""


def object_of(owner: type, data: Mapping[str, Any]) -> Any:
    """Makes an object of a dataclass from the values of its fields, no more and no fewer.

    >>> from companion.flight_events.facts import PlaceLost
    >>> object_of(PlaceLost, {"place": "A", "away_m": 2})
    PlaceLost(place='A', away_m=2.0)

    Raises:
        Unfit: a field is missing, there is another one, or a value is not of its field's type.
    """
    values = {}
    for name, read in _readers(owner).items():
        try:
            values[name] = read(data[name])
        except KeyError as error:
            raise Unfit(f"{name} is missing here") from error
        except Unfit as error:
            raise Unfit(f"{name} is not of its type here") from error
    if len(values) < len(data):
        raise Unfit(f"{min(data.keys() - values.keys())} has no place here")
    return owner(**values)


@cache
def _readers(owner: type) -> dict[str, _Reader]:
    return {field.name: _reader(field.type) for field in fields_of(owner)}


def _reader(type_: Any) -> _Reader:
    origin, arguments = get_origin(type_), get_args(type_)
    if type_ in _SCALARS:
        return partial(_scalar, type_)
    if type_ is float:
        return _float
    if origin is Literal:
        return partial(_literal, arguments)
    if origin is UnionType:
        return partial(_first, tuple(map(_reader, arguments)))
    if origin is tuple and arguments[-1] is Ellipsis:
        return partial(_list, _reader(arguments[0]))
    if origin is tuple:
        return partial(_tuple, tuple(map(_reader, arguments)))
    if origin is Mapping:
        return partial(_mapping, _reader(arguments[1]))
    if issubclass(type_, Enum):
        return partial(_member, type_)
    if issubclass(type_, tuple):
        items = tuple(map(_reader, item_types(type_)))
        return lambda value: type_(*_tuple(items, value))
    return partial(_object, type_)


def _demand(is_fit: bool) -> None:
    if not is_fit:
        raise Unfit


def _scalar(type_: type, value: Any) -> Any:
    _demand(type(value) is type_)
    return value


def _float(value: Any) -> float:
    _demand(type(value) in (int, float) and math.isfinite(value))
    return float(value)


def _literal(values: tuple[Any, ...], value: Any) -> Any:
    _demand(any(value == each and type(value) is type(each) for each in values))
    return value


def _first(readers: tuple[_Reader, ...], value: Any) -> Any:
    """A value as the first of some types that it fits."""
    for read in readers:
        try:
            return read(value)
        except Unfit:
            continue
    raise Unfit


def _list(read: _Reader, value: Any) -> tuple[Any, ...]:
    _demand(type(value) is list)
    return tuple(map(read, value))


def _tuple(readers: tuple[_Reader, ...], value: Any) -> tuple[Any, ...]:
    _demand(type(value) is list and len(value) == len(readers))
    return tuple(read(each) for read, each in zip(readers, value, strict=True))


def _mapping(read: _Reader, value: Any) -> dict[str, Any]:
    _demand(type(value) is dict)
    return {key: read(each) for key, each in value.items()}


def _member(type_: type[Enum], value: Any) -> Enum:
    try:
        return type_(value)
    except ValueError as error:
        raise Unfit from error


def _object(owner: type, value: Any) -> Any:
    _demand(type(value) is dict)
    return object_of(owner, value)
