"""Places found in flight: another program reports where in their region they are.

    places:
      Person: {east_m: 20, north_m: 10, up_m: 4, radius_m: 15, found_by: personSeen}
    events:
      personSeen: {when: "EVENT[person] > 0", latch: true}
    task:
      help: G (personSeen -> F at(Person))

Nothing flies to such a place before the event has come. The mission gives a region in which the
place may lie; it is checked like the region of any other place. A report outside is refused, so no
report leads the vehicle anywhere that the author has not allowed.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from companion.documents import Document, did_you_mean
from companion.errors import MissionError
from companion.mission.events import Event
from companion.mission.facts import AT, Fact
from companion.mission.places import Place, PointOfInterest
from companion.mission.signals import Condition
from companion.mission.skills import Skill

FOUND = 1.0
"""The value of the signal once a report has been accepted."""


def report_of(event: Event) -> str:
    """The name of the report by which an event finds a place."""
    return event.when.signal.instance


def check_found(
    places: Mapping[str, Place],
    events: Mapping[str, Event],
    skills: Mapping[str, Skill],
    sets: Mapping[str, tuple[str, ...]],
    initially: frozenset[Fact],
    document: Document,
) -> None:
    """Checks the places that are found in flight.

    Raises:
        MissionError: at the key that does not fit a place found by a report.
    """
    found = {name: place.found_by for name, place in places.items() if place.found_by}
    reports: dict[str, str] = {}
    for name, event_name in found.items():
        where = document.where("places", name, "found_by")
        event = events.get(event_name)
        if event is None:
            hint = f"events are {', '.join(events) or 'none yet'}. "
            what = f"place {name} is found by {event_name}, which is not an event"
            raise MissionError(what, where, (hint + did_you_mean(event_name, events)).rstrip())
        if why := _why_not(event):
            hint = f'write {event_name}: {{when: "EVENT[name] > 0", latch: true}}'
            raise MissionError(f"place {name} cannot be found by {event_name}: {why}", where, hint)
        other = reports.setdefault(report_of(event), name)
        if other != name:
            what = f"places {other} and {name} are found by the same report"
            raise MissionError(what, where, "a report says where one place is")
        if places[name].marker is not None:
            what = f"place {name} has a marker, and where it is, is known in flight alone"
            where = document.key_at("places", name, "marker")
            raise MissionError(what, where, "a marker lies at a place that is known beforehand")
        if places[name].suggesters:
            what = f"place {name} has suggesters, and it is where it was found"
            where = document.key_at("places", name, "suggesters")
            raise MissionError(what, where, "remove them; its tests judge where it was found")
        if Fact(AT, (name,)) in initially:
            what = f"the mission begins at {name}, which is only found in flight"
            raise MissionError(what, where, "begin at another place")
    for skill in skills.values():
        if looked_at := next(iter(_looked_at(skill, sets, found)), None):
            raise MissionError(
                f"{skill.name} looks at {looked_at}, and where that is, is known in flight alone",
                document.where("skills", skill.name, "look_at"),
                "look at another place, or at a point",
            )


def _why_not(event: Event) -> str | None:
    """Why an event cannot find a place; None if it can."""
    when = event.when
    if not when.signal.is_report:
        return f"{when.signal} is not a report of another program"
    if not isinstance(when, Condition) or not when.is_met_by(FOUND) or when.is_met_by(0.0):
        return "it does not come when something is found"
    return None if event.latch else "what was found stays found, and the event does not"


def _looked_at(
    skill: Skill, sets: Mapping[str, tuple[str, ...]], found: Mapping[str, str]
) -> Iterator[str]:
    match skill.look_at:
        case PointOfInterest(name=name):
            yield from {name} & set(found)
        case str(parameter):
            members = sets.get(dict(skill.parameters).get(parameter, ""), ())
            yield from (member for member in members if member in found)
