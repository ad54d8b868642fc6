"""Reads a mission with its map, and checks that it can be flown as it is written.

A door: it opens files. The input is a file, a text or data. The output is the frozen `Mission` of
model.py, in SI units and local NED, or one MissionError with file:line:column (for data: the path
of keys).

1. The YAML and its keys are checked (documents, schema.py); PDDL files complete them.
2. Each part is read by itself, as far as possible (parts.py).
3. If all parts are whole, it is checked that they fit together (fitting.py).
4. If it is to be flown here, the functions that it calls have to be installed.

One run reports all mistakes that are certain. Whether the task can be fulfilled is the planner's
question.
"""

from __future__ import annotations

import json
from pathlib import Path

from companion.arguments import path_of
from companion.documents import Document, Given, Source, begin_reading, read_source
from companion.mission.fitting import Fitted, fitted
from companion.mission.installed_calls import check_installed
from companion.mission.model import Mission
from companion.mission.other_files import refuse_other_files
from companion.mission.parts import MissionParts, read_parts
from companion.mission.pddl_domain import DomainReader, with_domain
from companion.mission.schema import MissionFile
from companion.mission.stand_ins import STAND_INS
from companion.mission.task_lines import lines_at
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
    read = read_source(source, "mission", within)
    refuse_other_files(read)
    file, document, reading = begin_reading(read.content, read.name, MissionFile, STAND_INS)
    if file.domain or not all(map(reading.is_whole, ("domain", "problem"))):
        reading.tell()  # the domain says what skills and facts there are
    file, declared = domain_of(file, document, read.folder)
    parts = read_parts(file, declared, read.folder, document, reading)
    mission = _mission(file, parts, fitted(file, declared, parts, document), read, document)
    if installed is not None:
        check_installed(mission.skills, mission.places, document, installed)
    return mission


def _mission(
    file: MissionFile, parts: MissionParts, fit: Fitted, read: Source, document: Document
) -> Mission:
    space = parts.space
    return Mission(
        name=file.name,
        path=str(read.path or ""),
        text=_text(read, document),
        grid=space.grid,
        map_file=space.map_file,
        walls=space.walls,
        limits=space.limits,
        vehicle=parts.vehicle,
        places=fit.places,
        sets=parts.sets,
        events=parts.events,
        skills=parts.skills,
        initially=parts.initially,
        task=parts.task,
        otherwise=fit.otherwise,
        patience_s=file.patience_s,
        tree=fit.tree,
        priorities=fit.priorities,
        anchor=parts.coordinates.anchor,
        battery=parts.battery,
        ready=fit.ready,
        lines_at=lines_at(file, document),
    )


def _text(source: Source, document: Document) -> str:
    """The mission as YAML text; data is written as JSON, which is also YAML."""
    if isinstance(source.content, str):
        return source.content
    return json.dumps(document.data(), indent=2, ensure_ascii=False) + "\n"
