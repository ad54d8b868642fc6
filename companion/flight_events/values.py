"""Values of JSON as values of a type: strict, without conversions but those of JSON itself.

Types are those that fields of events have: str, int, float, bool, None, enums, tuples of one type
or of several, mappings from str, dataclasses, named tuples, and unions of these.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from enum import Enum
from types import NoneType, UnionType
from typing import Any, get_args, get_origin

from companion.flight_events.fields import item_types, keys_of

_SCALARS = (str, int, bool, NoneType)


class Unfit(Exception):
    """A value is not of its type."""


def value_of(type_: Any, data: Mapping[str, Any], key: str) -> Any:
    """The value of a key.

    >>> value_of(tuple[str, ...], {"facts": ["at(A)"]}, "facts")
    ('at(A)',)

    Raises:
        Unfit: there is none, or it is not of the type.
    """
    try:
        return _converted(type_, data[key])
    except (KeyError, Unfit) as error:
        raise Unfit(f"{key} is missing here, or not of its kind") from error


def _converted(type_: Any, value: Any) -> Any:
    origin, arguments = get_origin(type_), get_args(type_)
    if type_ in _SCALARS:
        _demand(type(value) is type_)
        return value
    if type_ is float:
        _demand(type(value) in (int, float) and math.isfinite(value))
        return float(value)
    if origin is UnionType:
        return _first(arguments, value)
    if origin is tuple:
        return _tuple(arguments, value)
    if origin is Mapping:
        _demand(isinstance(value, dict))
        return {key: _converted(arguments[1], each) for key, each in value.items()}
    if issubclass(type_, Enum):
        return _member(type_, value)
    if issubclass(type_, tuple):
        return type_(*_tuple(item_types(type_), value))
    return _object(type_, value)


def _member(type_: type[Enum], value: Any) -> Enum:
    try:
        return type_(value)
    except ValueError as error:
        raise Unfit from error


def _demand(is_fit: bool) -> None:
    if not is_fit:
        raise Unfit


def _first(types: tuple[Any, ...], value: Any) -> Any:
    """A value as the first of some types that it fits."""
    for type_ in types:
        try:
            return _converted(type_, value)
        except Unfit:
            continue
    raise Unfit


def _tuple(types: tuple[Any, ...], value: Any) -> tuple[Any, ...]:
    _demand(isinstance(value, list))
    if types[-1] is Ellipsis:
        return tuple(_converted(types[0], each) for each in value)
    _demand(len(types) == len(value))
    return tuple(_converted(type_, each) for type_, each in zip(types, value, strict=True))


def _object(owner: type, value: Any) -> Any:
    """A dataclass, of which all fields are keys."""
    fields = keys_of(owner)
    _demand(isinstance(value, dict) and value.keys() == {field.name for field in fields})
    return owner(**{field.name: _converted(field.type, value[field.name]) for field in fields})
