"""Events as JSON: what a line of events.jsonl holds, and the page of the monitor gets.

A line has `t_s`, `kind`, `text`, and a key for each field of the event, in the order in which its
class declares them. Objects within are dataclasses, arrays are tuples.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from enum import Enum

from companion.flight_events.event import Stamped
from companion.flight_events.fields import Carrier, fields_of

_SCALARS = frozenset({str, int, float, bool, type(None)})


def line_of(stamped: Stamped) -> dict[str, object]:
    """The JSON object of a line.

    >>> from companion.flight_events.skills import PlaceReached
    >>> line_of(Stamped(7.25, PlaceReached("A", action="move(Home, A)")))
    {'t_s': 7.25, 'kind': 'at', 'text': 'at A', 'action': 'move(Home, A)'}
    """
    event = stamped.event
    about = {"t_s": stamped.time_s, "kind": event.kind, "text": event.text}
    return about | json_of(event)


def json_of(owner: object) -> dict[str, object]:
    """The keys of a dataclass, e.g. an event, with values that JSON can hold.

    >>> from companion.flight_events.facts import MissionEventChanged
    >>> json_of(MissionEventChanged("lowBattery", holds=True))
    {'event': 'lowBattery', 'holds': True}
    """
    found: dict[str, object] = {}
    for field in fields_of(type(owner)):
        if field.carrier is Carrier.KEY:
            found[field.name] = _value(getattr(owner, field.name))
        elif field.carrier is Carrier.KEYS:
            found |= json_of(getattr(owner, field.name))
    return found


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
