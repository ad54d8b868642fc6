"""Checks that the parts of a mission fit together, and reads what several of them decide."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import NamedTuple

from companion.documents import Document, DocumentReading, did_you_mean
from companion.errors import MissionError
from companion.mission.charging import refuse_charge_in_the_air
from companion.mission.event_entries import check_restored
from companion.mission.events import Event
from companion.mission.found_places import check_found
from companion.mission.landing_sites import check_landings, with_markers
from companion.mission.looking import check_looking
from companion.mission.otherwise import LandAtSafePlace, Otherwise
from companion.mission.parts import MissionParts
from companion.mission.pddl_domain import Predicates
from companion.mission.places import Place
from companion.mission.safe_places import read_otherwise
from companion.mission.schema import MissionFile
from companion.mission.skills import Skill
from companion.mission.task_lines import priorities_of, read_ready
from companion.mission.tree import read_tree
from companion.mission.tree_nodes import Tree


class Fitted(NamedTuple):
    """What several parts of a mission decide together; the attributes are those of `Mission`.

    Attributes:
        places: with the markers on which skills land.
    """

    places: Mapping[str, Place]
    otherwise: Otherwise | LandAtSafePlace
    priorities: Mapping[str, int]
    ready: tuple[str, ...]
    tree: Tree | None


def fitted(
    file: MissionFile, declared: Predicates, parts: MissionParts, document: Document
) -> Fitted:
    """What the parts decide together, if they fit.

    Args:
        file: the mission file.
        declared: facts that a PDDL domain declares.
        parts: what the file says.
        document: where the file's keys are.

    Raises:
        MissionError: with everything that does not fit.
    """
    skills, events, sets = parts.skills, parts.events, parts.sets
    grid, vehicle = parts.space.grid, parts.vehicle
    fitting = DocumentReading()
    places = fitting.check(with_markers, parts.places, file, grid, vehicle, document)
    if places:
        fitting.check(check_landings, skills, places, sets, grid, vehicle, document)
    places = places or parts.places
    given = {*declared, *(fact.predicate for fact in parts.initially)}
    fitting.check(_check_reachable_names, skills, given, events, document)
    fitting.check(check_restored, file, skills, document)
    fitting.check(check_looking, skills, places, sets, document)
    fitting.check(refuse_charge_in_the_air, skills, document)
    fitting.check(check_found, places, events, skills, sets, parts.initially, document)
    priorities = fitting.check(priorities_of, file, document)
    otherwise = fitting.check(read_otherwise, file, places, grid, vehicle, document)
    tree = fitting.check(_tree, file, parts, document)
    ready = fitting.check(read_ready, file, document, parts.task)
    fitting.tell()
    assert priorities is not None and otherwise is not None and ready is not None
    return Fitted(places, otherwise, priorities, ready, tree)


def _tree(file: MissionFile, parts: MissionParts, document: Document) -> Tree | None:
    if file.tree and file.battery is not None:
        where = document.key_at("battery")
        hint = "leave battery: out, or tree:, so that the task is planned for"
        raise MissionError("a tree by hand keeps no reserve of the battery", where, hint)
    if file.tree:
        return read_tree(file.tree, file.subtrees, document, parts)
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
