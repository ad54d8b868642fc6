"""Checks the names of a mission, the members of its sets, and the ids of its components."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from companion.documents import Document, DocumentReading, did_you_mean
from companion.errors import FormulaError, MissionError
from companion.ltl.formula import Operator
from companion.ltl.parser import parse
from companion.mission.facts import AT, HERE
from companion.mission.schema import MissionFile

_SHOWN = 20  # names listed in a message
_COMPANION = 191  # MAV_COMP_ID_ONBOARD_COMPUTER, by which the companion itself is heard


def check_names(file: MissionFile, document: Document, reading: DocumentReading) -> None:
    """Refuses names that formulas cannot use or that are ambiguous, and other wrong entries."""
    if HERE in file.places:
        reading.check(_refuse_here, document)
    for name in file.events:
        reading.check(_check_event, name, document)
    for name in file.components:
        reading.check(_check_component, name, file, document)
    reading.read(("objects",), _check_objects, file, document)
    if all(map(reading.knows, ("places", "objects"))):
        things = dict.fromkeys([*file.places, *file.objects])
        for name in file.sets:
            reading.read(("sets", name), _check_set, name, things, file, document)


def _refuse_here(document: Document) -> None:
    raise MissionError(
        f"a place cannot be called {HERE}",
        document.key_at("places", HERE),
        "the planner uses this name for the vehicle's present position",
    )


def _check_event(name: str, document: Document) -> None:
    if _operator(name) is not Operator.ATOM or name == AT:
        raise MissionError(
            f"an event cannot be called {name}",
            document.key_at("events", name),
            "this word has a meaning of its own in formulas; choose another name",
        )


def _check_component(name: str, file: MissionFile, document: Document) -> None:
    if file.components[name] == _COMPANION:
        raise MissionError(
            f"the component {name} is {_COMPANION}, which is the companion itself",
            document.where("components", name),
            f"give {name} another id, here and where it runs: two components with one id answer "
            "for each other",
        )


def _check_objects(file: MissionFile, document: Document) -> None:
    for index, name in enumerate(file.objects):
        if name in file.places or name in file.objects[:index]:
            raise MissionError(
                f"{name} is twice among the places and objects",
                document.where("objects", index),
                "an object is a thing that is not a place; remove one of the two",
            )


def _check_set(
    name: str, things: Mapping[str, None], file: MissionFile, document: Document
) -> None:
    members = file.sets[name]
    for index, member in enumerate(members):
        if member not in things:
            kinds = "place or object" if file.objects else "place"
            raise MissionError(
                f"unknown {kinds} {member} in the set {name}",
                document.where("sets", name, index),
                f"{kinds.replace(' or ', 's and ')}s are {_listing(things)}. "
                f"{did_you_mean(member, things)}".rstrip(),
            )
        if member in members[:index]:
            where = document.where("sets", name, index)
            raise MissionError(f"{member} is twice in the set {name}", where, "remove one of them")


def _listing(names: Iterable[str]) -> str:
    listed = list(names)
    return ", ".join(listed[:_SHOWN]) + (", ..." if len(listed) > _SHOWN else "")


def _operator(name: str) -> Operator | None:
    """Returns the operator that formulas would read instead of a name; None if there is none."""
    try:
        return parse(name).operator
    except FormulaError:
        return None
