"""Events of a class with values made up by hypothesis."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from enum import Enum
from types import UnionType
from typing import Any, Literal, get_args, get_origin

from hypothesis import strategies as st

from companion.flight_events.event import FlightEvent
from companion.flight_events.event_fields import fields_of, item_types

TEXT = st.text(st.characters(codec="utf-8"), max_size=12)
SCALARS: dict[Any, st.SearchStrategy[Any]] = {
    str: TEXT,
    int: st.integers(),
    float: st.floats(allow_nan=False, allow_infinity=False),
    bool: st.booleans(),
    type(None): st.none(),
}


def events_of(kind: type[FlightEvent]) -> st.SearchStrategy[FlightEvent]:
    """Events of a class."""
    return _objects(kind)


def _objects(owner: type) -> st.SearchStrategy[Any]:
    return st.builds(owner, **{field.name: _values(field.type) for field in fields_of(owner)})


def _values(type_: Any) -> st.SearchStrategy[Any]:
    origin, arguments = get_origin(type_), get_args(type_)
    if type_ in SCALARS:
        return SCALARS[type_]
    if origin is Literal:
        return st.sampled_from(arguments)
    if origin is UnionType:
        return st.one_of(*(_values(each) for each in arguments))
    if origin is tuple and arguments[-1] is Ellipsis:
        return st.lists(_values(arguments[0]), max_size=4).map(tuple)
    if origin is tuple:
        return st.tuples(*(_values(each) for each in arguments))
    if origin is Mapping:
        return st.dictionaries(TEXT, _values(arguments[1]), max_size=3)
    if issubclass(type_, Enum):
        return st.sampled_from(type_)
    if isinstance(type_, type) and dataclasses.is_dataclass(type_):
        return _objects(type_)
    return st.builds(type_, *(_values(each) for each in item_types(type_)))
