"""Lines of events.jsonl as events, with the classes that have written them.

The `type` of a line names the class, and the class says which other keys there are and of which
types they are: no more and no fewer. `kind` and `text` are for people, and are not read.
"""

from __future__ import annotations

import json
from typing import Any

from companion.errors import Location, MissionError
from companion.flight_events.catalogue import RECORDED
from companion.flight_events.event import FlightEvent, Stamped
from companion.flight_events.values import Unfit, object_of

MAX_S = 1e9
_CLASSES = {event.__name__: event for event in RECORDED}


def read_line(line: str | bytes, where: Location | None = None) -> Stamped:
    """Reads a line of events.jsonl.

    >>> text = '"kind": "lost", "text": "no longer at A: 2.4 m away"'
    >>> read_line('{"t_s": 7.25, "type": "PlaceLost", %s, "place": "A", "away_m": 2.4}' % text)
    Stamped(time_s=7.25, event=PlaceLost(place='A', away_m=2.4))

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
        time_s, event = _time_s(data.pop("t_s")), _class(data.pop("type"))
        del data["kind"], data["text"]
        return Stamped(time_s, object_of(event, data))
    except KeyError as error:
        raise MissionError(f"{error.args[0]} is missing here", where) from error
    except Unfit as error:
        raise MissionError(str(error), where) from error


def _time_s(found: Any) -> float:
    if isinstance(found, bool) or not isinstance(found, int | float) or not 0 <= found < MAX_S:
        raise Unfit("t_s is not a time in seconds")
    return float(found)


def _class(name: Any) -> type[FlightEvent]:
    found = _CLASSES.get(name) if isinstance(name, str) else None
    if found is None:
        raise Unfit(f"{name} is not a type of event")
    return found
