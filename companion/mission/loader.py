"""Reads a mission with its map, and checks that it can be flown as it is written.

A door: it opens files. In goes a file, a text or data, out comes the frozen `Mission` of model.py
in SI units and local NED, or one MissionError with file:line:column (for data: the path of keys).
In the order of the checks: the YAML and its keys (documents.py, schema.py), names, the places on
the map, events, skills, and last the facts that `initially` and `task` mention, against all that
the mission defines.

Whether the task can be fulfilled is found by the planner.
"""

from __future__ import annotations

import json
from collections.abc import Collection, Iterable, Mapping
from pathlib import Path

from companion.documents import (
    Document,
    Given,
    MistakeGathering,
    Source,
    did_you_mean,
    read_source,
    validate,
)
from companion.errors import FormulaError, MissionError
from companion.ltl.formula import Operator
from companion.ltl.parser import parse
from companion.mission.battery import read_battery
from companion.mission.charging import refuse_charge_in_the_air
from companion.mission.coordinates import coordinates_of
from companion.mission.event_entries import check_restored, read_events
from companion.mission.facts import AT, HERE, Fact
from companion.mission.found_places import check_found
from companion.mission.installed_calls import check_installed
from companion.mission.landing_sites import check_landings, with_markers
from companion.mission.literals import parse_fact
from companion.mission.looking import check_looking
from companion.mission.model import Event, Mission, Place, Skill
from companion.mission.one_place import check_one_place
from companion.mission.other_files import refuse_other_files
from companion.mission.pddl_domain import DomainReader, with_domain
from companion.mission.safe_places import read_otherwise
from companion.mission.schema import MissionFile
from companion.mission.sites import check_places
from companion.mission.skills import build_skills
from companion.mission.space import read_space
from companion.mission.task_lines import read_ready, read_task
from companion.mission.tree import read_tree
from companion.mission.tree_nodes import Tree
from companion.mission.vocabulary import Vocabulary
from companion.motion.grid import OccupancyGrid
from companion.skills.installed import InstalledReader, read_installed
from companion.vehicle_files import read_vehicle
from companion.vehicle_profile import VehicleProfile

_SHOWN = 20  # names listed in a message


def load_mission(
    source: Given,
    folder: Path | None = None,
    domain_of: DomainReader = with_domain,
    installed: InstalledReader | None = read_installed,
) -> Mission:
    """Reads a mission and its map.

    >>> from companion import load_mission
    >>> mission = load_mission("missions/surveillance.yaml")
    >>> mission.name, list(mission.places), str(mission.task["return"])
    ('surveillance', ['Home', 'A', 'B', 'C', 'r1', 'r2', 'r3'], 'G(targetReported -> X at(Home))')

    Args:
        source: the path of a YAML file; the YAML text itself, which has a line break; or a dict.
        folder: what the names of map and PDDL files are relative to; by default the folder of
            the mission's own file, or the current one.
        domain_of: reads the PDDL files.
        installed: says which functions are installed, if the mission calls any; None to read a
            mission that is not to be flown here.

    Raises:
        MissionError: a file is missing, or something in it cannot be used: where, as file, line and
            column (`<mission>` for the file of a text), or as keys of data, e.g. `task.search`.
    """
    mission, document = _read_mission(source, folder, domain_of)
    if installed is not None:
        check_installed(mission.skills, mission.places, document, installed)
    return mission


def _read_mission(
    source: Given, folder: Path | None, domain_of: DomainReader
) -> tuple[Mission, Document]:
    read = read_source(source, "mission", folder)
    refuse_other_files(read)
    file, document = validate(read.content, read.name, MissionFile)
    file, declared = domain_of(file, document, read.folder)
    _check_names(file, document)
    coordinates = coordinates_of(file, document)
    space = read_space(file, read.folder, coordinates, document)
    places, vehicle = space.places, read_vehicle(file.vehicle, read.folder, document)
    about_room = space.limits, space.grid, vehicle, coordinates, document
    mistakes = MistakeGathering()
    mistakes.read(lambda: check_places(space.places, *about_room))
    events = mistakes.read(lambda: read_events(file, document)) or {}
    effects = {name: entry.effect for name, entry in file.skills.items()}
    vocabulary = Vocabulary(places, file.events, file.objects, declared, effects)
    skills = mistakes.read(lambda: build_skills(file, document, vocabulary, coordinates)) or {}
    mistakes.tell()
    places = with_markers(places, file, space.grid, vehicle, document)
    initially = _initially(file, document, vocabulary)
    _check_reachable_names(skills, {*declared, *(f.predicate for f in initially)}, events, document)
    sets = {name: tuple(members) for name, members in file.sets.items()}
    _check_skills(skills, places, sets, (space.grid, vehicle), document, file)
    check_found(places, events, skills, sets, initially, document)
    task, priorities = read_task(file, document, vocabulary)
    mission = Mission(
        name=file.name,
        path=str(read.path or ""),
        text=_text(read, document),
        grid=space.grid,
        map_file=space.map_file,
        walls=space.walls,
        limits=space.limits,
        vehicle=vehicle,
        places=places,
        sets=sets,
        events=events,
        skills=skills,
        initially=initially,
        task=task,
        otherwise=read_otherwise(file, places, space.grid, vehicle, document),
        patience_s=file.patience_s,
        tree=_tree(file, document, skills, sets, vocabulary),
        priorities=priorities,
        anchor=coordinates.anchor,
        battery=read_battery(file.battery, vehicle, document),
        ready=read_ready(file, document, task),
    )
    return mission, document


def _check_skills(
    skills: Mapping[str, Skill],
    places: Mapping[str, Place],
    sets: Mapping[str, tuple[str, ...]],
    room: tuple[OccupancyGrid, VehicleProfile],
    document: Document,
    file: MissionFile,
) -> None:
    """Refuses skills after which the vehicle is nowhere; looks, landings, charges that cannot be.

    And events that restore what no skill assumes.
    """
    check_restored(file, skills, document)
    check_one_place(skills, places, document)
    check_looking(skills, places, sets, document)
    check_landings(skills, places, sets, *room, document)
    refuse_charge_in_the_air(skills, document)


def _text(source: Source, document: Document) -> str:
    """The mission as a YAML text; data are written as JSON, which is YAML too."""
    if isinstance(source.content, str):
        return source.content
    return json.dumps(document.data(), indent=2, ensure_ascii=False) + "\n"


def _tree(
    file: MissionFile,
    document: Document,
    skills: Mapping[str, Skill],
    sets: Mapping[str, Collection[str]],
    vocabulary: Vocabulary,
) -> Tree | None:
    if file.tree:
        if file.battery is not None:
            where = document.key_at("battery")
            hint = "leave battery: out, or tree:, so that the task is planned for"
            raise MissionError("a tree by hand keeps no reserve of the battery", where, hint)
        return read_tree(file.tree, file.subtrees, document, skills, sets, vocabulary)
    if file.subtrees:
        where = document.key_at("subtrees")
        raise MissionError("there are subtrees, and no tree", where, "add tree: [...] to use them")
    return None


def _check_names(file: MissionFile, document: Document) -> None:
    """Refuses names that formulas cannot use or that mean two things, and wrong members of sets."""
    if HERE in file.places:
        raise MissionError(
            f"a place cannot be called {HERE}",
            document.key_at("places", HERE),
            "the planner uses this name for the vehicle's present position",
        )
    for name in file.events:
        if _operator(name) is not Operator.ATOM or name == AT:
            raise MissionError(
                f"an event cannot be called {name}",
                document.key_at("events", name),
                "this word has a meaning of its own in formulas; choose another name",
            )
    things = dict.fromkeys(file.places)
    for index, name in enumerate(file.objects):
        if name in things:
            raise MissionError(
                f"{name} is twice among the places and objects",
                document.where("objects", index),
                "an object is a thing that is no place; remove one of the two",
            )
        things[name] = None
    for name, members in file.sets.items():
        seen: set[str] = set()
        for index, member in enumerate(members):
            if member not in things:
                kinds = "place or object" if file.objects else "place"
                raise MissionError(
                    f"unknown {kinds} {member} in the set {name}",
                    document.where("sets", name, index),
                    f"{kinds.replace(' or ', 's and ')}s are {_listing(things)}. "
                    f"{did_you_mean(member, things)}".rstrip(),
                )
            if member in seen:
                where = document.where("sets", name, index)
                raise MissionError(
                    f"{member} is twice in the set {name}", where, "remove one of them"
                )
            seen.add(member)


def _listing(names: Iterable[str]) -> str:
    listed = list(names)
    return ", ".join(listed[:_SHOWN]) + (", ..." if len(listed) > _SHOWN else "")


def _operator(name: str) -> Operator | None:
    """Returns the operator that a name is in formulas; None if it cannot stand alone."""
    try:
        return parse(name).operator
    except FormulaError:
        return None


def _initially(file: MissionFile, document: Document, vocabulary: Vocabulary) -> frozenset[Fact]:
    """Returns the facts that are listed; exactly one of them says where the vehicle is."""
    facts: set[Fact] = set()
    for index, text in enumerate(file.initially):
        with document.locating("initially", index):
            fact = parse_fact(text).instantiate({})
            vocabulary.check(text)
        if fact.predicate == AT and any(other.predicate == AT for other in facts):
            raise MissionError(
                "the vehicle cannot be at two places",
                document.where("initially", index),
                "keep one fact at(PLACE)",
            )
        facts.add(fact)
    if not any(fact.predicate == AT for fact in facts):
        hint = f"add to initially the place where it starts, e.g. at({next(iter(file.places))})"
        raise MissionError("no fact says where the vehicle is", document.where("initially"), hint)
    return frozenset(facts)


def _check_reachable_names(
    skills: Mapping[str, Skill],
    given: Collection[str],
    events: Mapping[str, Event],
    document: Document,
) -> None:
    """Refuses a condition that nothing ever makes true, such as a misspelt one.

    Args:
        given: names of facts that need no skill: what holds at the start, what PDDL declares.
        events: need none either.
    """
    sources = {*given, *events}
    for skill in skills.values():
        sources |= {atom.predicate for atom in skill.assumes}
        effects = (skill.effect, *(when.effect for when in skill.conditional))
        sources |= {x.atom.predicate for effect in effects for x in effect if x.is_positive}
    for skill in skills.values():
        conditions = [(literal, "precondition") for literal in skill.precondition]
        conditions += [(x, "effect") for when in skill.conditional for x in when.condition]
        for literal, key in conditions:
            name = literal.atom.predicate
            if name in events and events[name].is_pulse and literal.is_positive:
                raise MissionError(
                    f"{skill.name} waits for {name}, which never lasts until a skill begins",
                    document.where("skills", skill.name, key),
                    f"a command is there for a moment: give {name} latch: true, or until:",
                )
            if name not in sources:
                raise MissionError(
                    f"nothing ever makes {name} true",
                    document.where("skills", skill.name, key),
                    "it is no event, no effect, no belief and not listed in initially. "
                    f"{did_you_mean(name, sorted(sources))}".rstrip(),
                )
