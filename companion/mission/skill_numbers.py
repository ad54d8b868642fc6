"""Checks all skills of a mission together: calls end, and the planner can handle their number."""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import cache

from companion.documents import Document, did_you_mean
from companion.errors import MissionError
from companion.mission.python_call import PythonCall, check_names
from companion.mission.schema import MissionFile
from companion.mission.skills import Skill
from companion.mission.steps import Do

MAX_INSTANCES = 50_000  # actions of all skills; 220 places give `move` about that many
MAX_CONDITIONAL = 50_000  # conditional effects of all actions together
MAX_STEPS = 100_000  # steps of all actions, refined down to primitives


def check_skills(skills: Mapping[str, Skill], file: MissionFile, document: Document) -> None:
    """Checks all skills of a mission together.

    Raises:
        MissionError: there are too many to plan with, a skill refines itself, or a skill calls
            another one with the wrong number of arguments.
    """
    _check_numbers(skills, file, document)
    for name in skills:
        _check_calls(name, skills, file, document)
    _check_steps(skills, file, document)


def _check_numbers(skills: Mapping[str, Skill], file: MissionFile, document: Document) -> None:
    """Refuses more actions than the planner can handle."""
    instances = effects = 0
    for name, entry in file.skills.items():
        own = math.prod(len(file.sets[s]) for s in entry.parameters.values())
        instances += own
        effects += own * len(skills[name].conditional)
        for count, limit, what in (
            (instances, MAX_INSTANCES, "instances"),
            (effects, MAX_CONDITIONAL, "conditional effects"),
        ):
            if count > limit:
                raise MissionError(
                    f"with {name} the skills have {count} {what}, at most {limit} "
                    "can be planned with",
                    document.key_at("skills", name),
                    "give the skill fewer parameters, or smaller sets",
                )


def _check_steps(skills: Mapping[str, Skill], file: MissionFile, document: Document) -> None:
    """Refuses refinements that multiply, such as 20 skills that each call the next one twice."""

    @cache
    def steps(name: str) -> int:
        return sum(1 + steps(x.skill) if isinstance(x, Do) else 1 for x in skills[name].execute)

    count = 0
    for name, entry in file.skills.items():
        count += steps(name) * math.prod(len(file.sets[s]) for s in entry.parameters.values())
        if count > MAX_STEPS:
            raise MissionError(
                f"with {name} the actions have {count} steps, at most {MAX_STEPS} can be planned "
                "with",
                document.key_at("skills", name),
                "refine it into fewer skills, or give it fewer parameters",
            )


def _check_calls(
    name: str, skills: Mapping[str, Skill], file: MissionFile, document: Document
) -> None:
    """Refuses calls with a wrong number of arguments, and calls that lead back to the skill."""
    constants = {*file.places, *file.objects}
    for index, step in enumerate(skills[name].execute):
        where = document.where("skills", name, "execute", index)
        known = {parameter for parameter, _ in skills[name].parameters} | constants
        if isinstance(step, PythonCall):
            check_names(step, name, known, where)
        if not isinstance(step, Do):
            continue
        called = skills[step.skill]
        if len(called.parameters) != len(step.arguments):
            raise MissionError(
                f"{step.skill} is called with {len(step.arguments)} arguments",
                where,
                f"write {called.signature}",
            )
        for argument in step.arguments:
            if argument not in known:
                raise MissionError(
                    f"{argument} is not a parameter of {name}, place or object",
                    where,
                    did_you_mean(argument, sorted(known)),
                )
        if name in _called(step.skill, skills, frozenset()):
            raise MissionError(
                f"{name} is refined into itself", where, "a refinement has to end in primitives"
            )


def _called(name: str, skills: Mapping[str, Skill], seen: frozenset[str]) -> frozenset[str]:
    """Returns a skill and all skills that refine it, directly or not."""
    if name in seen:
        return seen
    seen |= {name}
    for step in skills[name].execute:
        if isinstance(step, Do):
            seen |= _called(step.skill, skills, seen)
    return seen
