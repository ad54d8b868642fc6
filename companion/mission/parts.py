"""Reads the parts of a mission, each as far as possible without the parts that are unusable.

The input is what the file says (schema.py). The output is all parts, or one MissionError that lists
what is wrong in all of them. A part that cannot be read is marked as unread (documents/reading.py):
its names stay known, and whatever needs it is not checked. fitting.py checks whether the parts fit
together; it only receives whole ones.
"""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

from companion.documents import Document, DocumentReading
from companion.errors import MissionError
from companion.ltl.timed_formula import Line
from companion.mission.battery import MissionBattery, read_battery
from companion.mission.coordinates import Coordinates, begins_at, coordinates_of
from companion.mission.event_entries import read_events
from companion.mission.events import Event
from companion.mission.facts import AT, Fact
from companion.mission.facts import at as at_place
from companion.mission.literals import is_begun, parse_fact
from companion.mission.names import check_names
from companion.mission.one_place import check_one_place
from companion.mission.pddl_domain import Predicates
from companion.mission.places import Place
from companion.mission.schema import MissionFile
from companion.mission.sites import check_places
from companion.mission.skill_entries import build_skills
from companion.mission.skills import Skill
from companion.mission.space import Space, check_corners, read_places, read_space
from companion.mission.task_lines import read_task
from companion.mission.vocabulary import Vocabulary
from companion.vehicle_files import read_vehicle
from companion.vehicle_profile import VehicleProfile


class MissionParts(NamedTuple):
    """What a mission file says; the attributes are those of `Mission`."""

    coordinates: Coordinates
    vehicle: VehicleProfile
    space: Space
    places: dict[str, Place]
    sets: dict[str, tuple[str, ...]]
    events: dict[str, Event]
    vocabulary: Vocabulary
    skills: dict[str, Skill]
    initially: frozenset[Fact]
    task: dict[str, Line]
    battery: MissionBattery | None


def read_parts(
    file: MissionFile,
    declared: Predicates,
    folder: Path,
    document: Document,
    reading: DocumentReading,
) -> MissionParts:
    """Reads all parts of a mission.

    Args:
        file: the mission file, as far as it could be read.
        declared: facts that a PDDL domain declares.
        folder: where relative names of other files begin.
        document: where the file's keys are.
        reading: what has been found wrong, and is unread, so far.

    Raises:
        MissionError: with everything that is wrong.
    """
    check_names(file, document, reading)
    coordinates = _coordinates(file, document, reading)
    vehicle = reading.read(("vehicle",), read_vehicle, file.vehicle, folder, document)
    places: dict[str, Place] = {}
    space = None
    if coordinates:
        places = read_places(file, coordinates, document, reading)
        space = read_space(file, folder, coordinates, document, reading)
    if space:
        reading.check(check_corners, space, places.values(), document)
    if space and vehicle and coordinates:
        check_places(places, space.limits, space.grid, vehicle, coordinates, document, reading)
    events = read_events(file, document, reading)
    vocabulary = _vocabulary(file, declared, reading)
    skills = build_skills(file, document, vocabulary, coordinates, reading)
    if len(skills) == len(file.skills) and all(map(reading.knows, ("places", "skills"))):
        reading.read(("skills",), check_one_place, skills, file.places, document)
    initially = _initially(file, document, vocabulary, reading)
    task = read_task(file, document, vocabulary, reading)
    battery = None
    if vehicle:
        battery = reading.read(("battery",), read_battery, file.battery, vehicle, document)
    reading.tell()
    assert coordinates and vehicle and space
    return MissionParts(
        coordinates=coordinates,
        vehicle=vehicle,
        space=space,
        places=places,
        sets={name: tuple(members) for name, members in file.sets.items()},
        events=events,
        vocabulary=vocabulary,
        skills=skills,
        initially=initially,
        task=task,
        battery=battery,
    )


def _coordinates(
    file: MissionFile, document: Document, reading: DocumentReading
) -> Coordinates | None:
    """The meaning of coordinates; in degrees it depends on where the mission begins."""
    needed: list[tuple[str, ...]] = [("frame",)]
    if file.frame == "wgs84":
        home = begins_at(file)
        needed += [("initially",), ("limits", "up_m"), ("places", home) if home else ("places",)]
    if not all(reading.is_whole(*keys) for keys in needed):
        return None
    return reading.read(("frame",), coordinates_of, file, document)


def _vocabulary(file: MissionFile, declared: Predicates, reading: DocumentReading) -> Vocabulary:
    """The facts that may exist; the skills add theirs later."""
    unread = [members for name, members in file.sets.items() if not reading.is_whole("sets", name)]
    return Vocabulary(
        file.places,
        file.events,
        file.objects,
        declared,
        {name: entry.effect for name, entry in file.skills.items()},
        things_are_known=all(map(reading.knows, ("places", "objects"))),
        is_open=not all(map(reading.knows, ("events", "skills"))),
        told=[at_place(member) for members in unread for member in members],
    )


def _initially(
    file: MissionFile, document: Document, vocabulary: Vocabulary, reading: DocumentReading
) -> frozenset[Fact]:
    """The facts that are listed; exactly one of them says where the vehicle is."""
    facts, is_split = [], False
    for index, text in enumerate(file.initially):
        if not (is_split and text.count(")") > text.count("(")):  # else half a fact
            keys = ("initially", index)
            facts.append(reading.read(keys, _listed_fact, index, file, document, vocabulary))
        is_split = is_begun(text)
    if reading.is_whole("initially"):
        listed = [fact for fact in facts if fact]
        reading.read(("initially",), _refuse_nowhere, file, document, listed)
    return frozenset(fact for fact in facts if fact)


def _listed_fact(index: int, file: MissionFile, document: Document, vocabulary: Vocabulary) -> Fact:
    text = file.initially[index]
    with document.locating("initially", index):
        fact = parse_fact(text).instantiate({})
        vocabulary.check(text)
    return fact


def _refuse_nowhere(file: MissionFile, document: Document, facts: list[Fact]) -> None:
    """Refuses a vehicle that is at no place, or at two."""
    indices = [index for index, fact in enumerate(facts) if fact.predicate == AT]
    if not indices:
        hint = f"add to initially the place where it starts, e.g. at({next(iter(file.places))})"
        raise MissionError("no fact says where the vehicle is", document.where("initially"), hint)
    if len(indices) > 1:
        raise MissionError(
            "the vehicle cannot be at two places",
            document.where("initially", indices[1]),
            "keep one fact at(PLACE)",
        )
