"""Lines of events.jsonl as events, with the classes that have written them.

A line is read strictly: its keys are those of a class of its kind, no more and no fewer, and each
value is of the field's type. What the text alone carries is read out of it by the template that
has made it. So writing what was read gives the same line.
"""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from string import Formatter
from typing import Any

from companion.errors import Location, MissionError
from companion.flight_events.catalogue import RECORDED
from companion.flight_events.event import FlightEvent, Stamped
from companion.flight_events.fields import Carrier, fields_of, keys_of
from companion.flight_events.values import Unfit, value_of

ABOUT = ("t_s", "kind", "text")
"""Keys of every line."""
MAX_S = 1e9


def read_line(line: str | bytes, where: Location | None = None) -> Stamped:
    """A line of events.jsonl.

    >>> read_line('{"t_s": 7.25, "kind": "at", "text": "at A", "action": "move(Home, A)"}')
    Stamped(time_s=7.25, event=PlaceReached(place='A', action='move(Home, A)'))

    Args:
        line: without or with its end.
        where: its place in the file, if known.

    Raises:
        MissionError: it is not as docs/run-folder.md describes it.
    """
    try:
        data = json.loads(line)
    except (ValueError, RecursionError) as error:
        raise MissionError("this line is not JSON", where) from error
    if not isinstance(data, dict):
        raise MissionError("this line is not a JSON object", where)
    try:
        kind, text = value_of(str, data, "kind"), value_of(str, data, "text")
        return Stamped(_time_s(data), _event(kind, text, data))
    except Unfit as error:
        raise MissionError(str(error), where) from error


def _time_s(data: Mapping[str, Any]) -> float:
    found = data.get("t_s")
    if isinstance(found, bool) or not isinstance(found, int | float) or not 0 <= found < MAX_S:
        raise Unfit("t_s is missing here, or no time in seconds")
    return float(found)


def _event(kind: str, text: str, data: Mapping[str, Any]) -> FlightEvent:
    """The event of the first class whose keys, values and text a line has."""
    classes = [event for event in RECORDED if event.kind == kind]
    if not classes:
        raise Unfit(f"{kind} is no kind of event")
    keys = data.keys() - set(ABOUT)
    alike = [event for event in classes if _keys(event) == keys]
    if not alike:
        raise Unfit(_difference(classes, keys))
    *others, last = alike
    for event in others:
        try:
            return _read(event, text, data, is_text_due=True)
        except Unfit:
            continue
    return _read(last, text, data, is_text_due=len(alike) > 1)


def _keys(event: type[FlightEvent]) -> set[str]:
    return {field.name for field in keys_of(event)}


def _difference(classes: list[type[FlightEvent]], keys: set[str]) -> str:
    """What the class that is most like a line has and the line has not, or the other way round."""
    nearest = min((_keys(event) for event in classes), key=lambda each: len(each ^ keys))
    if missing := sorted(nearest - keys):
        return f"{missing[0]} is missing here"
    return f"{min(keys - nearest)} has no place here"


def _read(
    event: type[FlightEvent], text: str, data: Mapping[str, Any], is_text_due: bool
) -> FlightEvent:
    values = _from_keys(event, data)
    in_text = [field for field in fields_of(event) if field.carrier is Carrier.TEXT]
    if in_text:
        found = re.fullmatch(_pattern(event, data), text, re.DOTALL)
        if found is None:
            raise Unfit(f'the text is not "{event.template}"')
        values |= {field.name: _from_text(field.type, found[field.name]) for field in in_text}
    made = event(**values)
    if (in_text or is_text_due) and made.text != text:
        raise Unfit(f'the text is not "{event.template}"')
    return made


def _from_keys(owner: type, data: Mapping[str, Any]) -> dict[str, Any]:
    """Arguments for a class; its fields that the text carries are wanting."""
    values = {}
    for field in fields_of(owner):
        if field.carrier is Carrier.KEYS:
            values[field.name] = field.type(**_from_keys(field.type, data))
        elif field.carrier is Carrier.KEY:
            value = value_of(field.type, data, field.name)
            if not field.is_constant:
                values[field.name] = value
            elif value != field.constant:
                raise Unfit(f"{field.name} is not {field.constant} here")
    return values


def _pattern(event: type[FlightEvent], data: Mapping[str, Any]) -> str:
    """A regular expression for the text of an event of which the keys of its line are known."""
    in_text = {field.name for field in fields_of(event) if field.carrier is Carrier.TEXT}
    pattern = ""
    for literal, name, _, _ in Formatter().parse(event.template):
        pattern += re.escape(literal)
        if name in in_text:
            pattern += f"(?P<{name}>.*)"
        elif name is not None:
            known = data.get(name)
            pattern += re.escape(str(known)) if isinstance(known, str | int) else ".*"
    return pattern


def _from_text(type_: Any, text: str) -> object:
    """A value of a field that the text carries: a string, a number, or of an enum."""
    try:
        return type_(text)
    except ValueError as error:
        raise Unfit(f"the text has {text} in a wrong place") from error
