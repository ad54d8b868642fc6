"""Events as JSON: what a line of events.jsonl holds, and the page of the monitor gets.

A line has `t_s`, the `type` of the event, which is its class, the `kind` and the `text` for people,
and a key for each field of the event, in the order in which its class declares them. Objects within
are dataclasses, arrays are tuples.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from enum import Enum

from companion.flight_events.event import Stamped
from companion.flight_events.event_fields import fields_of

_SCALARS = frozenset({str, int, float, bool, type(None)})


def line_of(stamped: Stamped) -> dict[str, object]:
    """Returns the JSON object of a line.

    >>> from companion.flight_events.facts import PlaceLost
    >>> line_of(Stamped(7.25, PlaceLost("A", away_m=2.4)))["type"]
    'PlaceLost'
    """
    event = stamped.event
    about = {
        "t_s": stamped.time_s,
        "type": type(event).__name__,
        "kind": event.kind,
        "text": event.text,
    }
    return about | json_of(event)


def json_of(owner: object) -> dict[str, object]:
    """Returns the fields of a dataclass, e.g. an event, with values that JSON can hold.

    >>> from companion.flight_events.facts import MissionEventChanged
    >>> json_of(MissionEventChanged("lowBattery", holds=True))
    {'event': 'lowBattery', 'holds': True}
    """
    return {field.name: _value(getattr(owner, field.name)) for field in fields_of(type(owner))}


def _value(value: object) -> object:
    if type(value) in _SCALARS:
        return value
    if isinstance(value, Enum):
        return value.value
    if isinstance(value, Mapping):
        return {key: _value(each) for key, each in value.items()}
    if isinstance(value, tuple):
        return [_value(each) for each in value]
    return json_of(value) if dataclasses.is_dataclass(value) else value
