"""Reads a mission with its map, and checks that it can be flown as it is written.

A door: it opens files. The input is a file, a text or data. The output is the frozen `Mission` of
model.py, in SI units and local NED, or one MissionError with file:line:column (for data: the path
of keys).

1. The YAML and its keys are checked (documents, schema.py).
2. Each part is read by itself, as far as possible (parts.py).
3. If all parts are whole, it is checked that they fit together.

One run reports all mistakes that are certain. Whether the task can be fulfilled is the planner's
question.
"""

from __future__ import annotations

import json
from collections.abc import Collection, Mapping
from pathlib import Path

from companion.arguments import path_of
from companion.documents import (
    Document,
    DocumentReading,
    Given,
    Source,
    begin_reading,
    did_you_mean,
    read_source,
)
from companion.errors import MissionError
from companion.mission.charging import refuse_charge_in_the_air
from companion.mission.event_entries import check_restored
from companion.mission.events import Event
from companion.mission.found_places import check_found
from companion.mission.installed_calls import check_installed
from companion.mission.landing_sites import check_landings, with_markers
from companion.mission.looking import check_looking
from companion.mission.model import Mission
from companion.mission.other_files import refuse_other_files
from companion.mission.parts import MissionParts, read_parts
from companion.mission.pddl_domain import DomainReader, Predicates, with_domain
from companion.mission.safe_places import read_otherwise
from companion.mission.schema import MissionFile
from companion.mission.skills import Skill
from companion.mission.stand_ins import STAND_INS
from companion.mission.task_lines import lines_at, priorities_of, read_ready
from companion.mission.tree import read_tree
from companion.mission.tree_nodes import Tree
from companion.mission.vocabulary import Vocabulary
from companion.skills.installed import InstalledReader, read_installed


def load_mission(
    source: Given,
    folder: Path | str | None = None,
    domain_of: DomainReader = with_domain,
    installed: InstalledReader | None = read_installed,
) -> Mission:
    """Reads a mission and its map.

    >>> from companion import load_mission
    >>> mission = load_mission("missions/surveillance.yaml")
    >>> mission.name, list(mission.places), str(mission.task["return"])
    ('surveillance', ['Home', 'A', 'B', 'C', 'r1', 'r2', 'r3'], 'G(targetReported -> X at(Home))')

    Args:
        source: the path of a YAML file; or the YAML text, which contains a line break; or a dict.
        folder: where the names of map and PDDL files begin; by default the folder of the mission
            file, or the current one.
        domain_of: reads the PDDL files.
        installed: says which functions are installed, if the mission calls any; None if the mission
            is not to be flown here.

    Raises:
        MissionError: a file is missing, or something in it cannot be used. It says where: file,
            line and column (`<mission>` as the file of a text), or keys of data, e.g.
            `task.search`.
        CompanionError: the folder is not a path.
    """
    within = path_of(folder, "the path of a folder") if folder is not None else None
    mission, document = _read_mission(source, within, domain_of)
    if installed is not None:
        check_installed(mission.skills, mission.places, document, installed)
    return mission


def _read_mission(
    source: Given, folder: Path | None, domain_of: DomainReader
) -> tuple[Mission, Document]:
    read = read_source(source, "mission", folder)
    refuse_other_files(read)
    file, document, reading = begin_reading(read.content, read.name, MissionFile, STAND_INS)
    if file.domain or not all(map(reading.is_whole, ("domain", "problem"))):
        reading.tell()  # the domain says what skills and facts there are
    file, declared = domain_of(file, document, read.folder)
    parts = read_parts(file, declared, read.folder, document, reading)
    mission = _fitted(file, declared, parts, read, document)
    return mission, document


def _fitted(
    file: MissionFile, declared: Predicates, parts: MissionParts, read: Source, document: Document
) -> Mission:
    """The mission, if its parts fit together."""
    space, skills, events, task = parts.space, parts.skills, parts.events, parts.task
    grid, vehicle = space.grid, parts.vehicle
    sets = {name: tuple(members) for name, members in file.sets.items()}
    fitting = DocumentReading()
    places = parts.places
    if marked := fitting.read(lambda: with_markers(places, file, grid, vehicle, document)):
        places = marked
        fitting.read(lambda: check_landings(skills, places, sets, grid, vehicle, document))
    given = {*declared, *(fact.predicate for fact in parts.initially)}
    fitting.read(lambda: _check_reachable_names(skills, given, events, document))
    fitting.read(lambda: check_restored(file, skills, document))
    fitting.read(lambda: check_looking(skills, places, sets, document))
    fitting.read(lambda: refuse_charge_in_the_air(skills, document))
    fitting.read(lambda: check_found(places, events, skills, sets, parts.initially, document))
    priorities = fitting.read(lambda: priorities_of(file, document))
    otherwise = fitting.read(lambda: read_otherwise(file, places, grid, vehicle, document))
    pulses = [name for name, event in events.items() if event.is_pulse]
    tree = fitting.read(lambda: _tree(file, document, skills, sets, parts.vocabulary, pulses))
    ready = fitting.read(lambda: read_ready(file, document, task))
    fitting.tell()
    assert priorities is not None and otherwise is not None and ready is not None
    return Mission(
        name=file.name,
        path=str(read.path or ""),
        text=_text(read, document),
        grid=space.grid,
        map_file=space.map_file,
        walls=space.walls,
        limits=space.limits,
        vehicle=parts.vehicle,
        places=places,
        sets=sets,
        events=events,
        skills=skills,
        initially=parts.initially,
        task=task,
        otherwise=otherwise,
        patience_s=file.patience_s,
        tree=tree,
        priorities=priorities,
        anchor=parts.coordinates.anchor,
        battery=parts.battery,
        ready=ready,
        lines_at=lines_at(file, document),
    )


def _text(source: Source, document: Document) -> str:
    """The mission as YAML text; data is written as JSON, which is also YAML."""
    if isinstance(source.content, str):
        return source.content
    return json.dumps(document.data(), indent=2, ensure_ascii=False) + "\n"


def _tree(
    file: MissionFile,
    document: Document,
    skills: Mapping[str, Skill],
    sets: Mapping[str, Collection[str]],
    vocabulary: Vocabulary,
    pulses: Collection[str],
) -> Tree | None:
    if file.tree:
        if file.battery is not None:
            where = document.key_at("battery")
            hint = "leave battery: out, or tree:, so that the task is planned for"
            raise MissionError("a tree by hand keeps no reserve of the battery", where, hint)
        return read_tree(file.tree, file.subtrees, document, skills, sets, vocabulary, pulses)
    if file.subtrees:
        where = document.key_at("subtrees")
        raise MissionError("there are subtrees, and no tree", where, "add tree: [...] to use them")
    return None


def _check_reachable_names(
    skills: Mapping[str, Skill],
    given: Collection[str],
    events: Mapping[str, Event],
    document: Document,
) -> None:
    """Refuses a condition that nothing can make true, such as a misspelt one.

    Args:
        given: names of facts that need no skill: those true at the start, those that PDDL declares.
        events: names of events, which need no skill either.
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
