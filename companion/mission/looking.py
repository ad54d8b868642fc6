"""Checks what skills look at: `look_at` names a parameter, a place, or a point."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import product

from companion.documents import Document, did_you_mean
from companion.errors import MissionError
from companion.geometry import horizontal_distance
from companion.mission.coordinates import Coordinates
from companion.mission.facts import AT
from companion.mission.places import Place, PointOfInterest
from companion.mission.refinement import flies, looks_while_holding, turns
from companion.mission.schema import MissionFile
from companion.mission.skill_schema import SkillEntry
from companion.mission.skills import Skill
from companion.mission.world_schema import LookAtEntry
from companion.motion.heading import FACING_M


def look_at(
    name: str, entry: SkillEntry, file: MissionFile, document: Document, coordinates: Coordinates
) -> str | PointOfInterest | None:
    """The parameter of a skill, or the point, at which the skill looks.

    Raises:
        MissionError: the parameter or place does not exist, or the parameter may be an object.
    """
    wanted, where = entry.look_at, document.where("skills", name, "look_at")
    if isinstance(wanted, LookAtEntry):
        point = coordinates.point(wanted, "skills", name, "look_at")
        return PointOfInterest(wanted.in_words, point, wanted.up_m)
    if wanted is None:
        return None
    if wanted in entry.parameters:
        for member in file.sets[entry.parameters[wanted]]:
            if member not in file.places:
                hint = f"places are {', '.join(file.places)}"
                raise MissionError(f"{name} cannot look at {member}, no place", where, hint)
        return wanted
    if wanted not in file.places:
        known = [*entry.parameters, *file.places]
        raise MissionError(
            f"{name} looks at {wanted}, which is not a parameter or place",
            where,
            f"write a place, or {{east_m: 0, north_m: 0}}. {did_you_mean(wanted, known)}".rstrip(),
        )
    return PointOfInterest(wanted, coordinates.point(file.places[wanted], "places", wanted))


def gimbal_of(name: str, entry: SkillEntry, file: MissionFile, document: Document) -> int | None:
    """The gimbal with which a skill looks at something, besides turning the vehicle.

    Raises:
        MissionError: the component does not exist, or the skill looks at nothing.
    """
    if entry.gimbal is None:
        return None
    where = document.where("skills", name, "gimbal")
    if entry.look_at is None:
        hint = "add look_at, or point it by a step gimbal(component, pitch_deg, yaw_deg)"
        raise MissionError(f"{name} has a gimbal, and looks at nothing", where, hint)
    if entry.gimbal not in file.components:
        known = ", ".join(file.components) or "none yet"
        hint = f"components are {known}. {did_you_mean(entry.gimbal, file.components)}".rstrip()
        raise MissionError(f"unknown component {entry.gimbal}", where, hint)
    return file.components[entry.gimbal]


def check_looking(
    skills: Mapping[str, Skill],
    places: Mapping[str, Place],
    sets: Mapping[str, tuple[str, ...]],
    document: Document,
) -> None:
    """Refuses a `look_at` that can never be carried out.

    Raises:
        MissionError: the companion turns the vehicle in no step of the skill; or the skill stays at
            a place and looks at a point above or below it.
    """
    for skill in skills.values():
        if skill.look_at is None:
            continue
        where = document.where("skills", skill.name, "look_at")
        if not turns(skill, skills):
            raise MissionError(
                f"{skill.name} does not fly, command or wait, so it looks at nothing",
                where,
                "remove look_at: the autopilot lands and takes off with the heading that it has",
            )
        if skill.gimbal is not None and not looks_while_holding(skill, skills):
            hint = "a gimbal points where the vehicle holds: add photo(), wait() or command()"
            what = f"{skill.name} holds nowhere, so its gimbal points at nothing"
            raise MissionError(what, document.where("skills", skill.name, "gimbal"), hint)
        if flies(skill, skills) or skill.gimbal is not None:
            continue
        for stays, looks in _pairs(skill, places, sets):
            if horizontal_distance(stays.position, looks.position) < FACING_M:
                what = f"{skill.name} looks at {looks.name} from {stays.name}"
                hint = f"look at what is {FACING_M:g} m away; distinct: keeps parameters apart"
                raise MissionError(f"{what}: no direction leads there", where, hint)


def _pairs(
    skill: Skill, places: Mapping[str, Place], sets: Mapping[str, tuple[str, ...]]
) -> Iterator[tuple[Place, PointOfInterest]]:
    """Each place where the skill may stay, with what it looks at from there."""
    members = {name: sets[set_name] for name, set_name in skill.parameters}
    target = skill.look_at
    if isinstance(target, str):
        looked_at, points = target, [places[place].point for place in members[target]]
    else:
        assert target is not None
        looked_at, points = target.name, [target]
    for here in _stays(skill):
        is_one = here == looked_at
        is_distinct = not is_one and any({here, looked_at} <= {*g} for g in skill.distinct)
        for stays, point in product(members.get(here, (here,)), points):
            if not is_distinct if stays == point.name else not is_one:
                yield places[stays], point


def _stays(skill: Skill) -> list[str]:
    """The parameter or place at which the skill begins; empty if it does not say."""
    atoms = [literal.atom for literal in skill.precondition if literal.is_positive]
    return [atom.arguments[0] for atom in atoms if atom.predicate == AT]
