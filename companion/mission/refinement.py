"""Answers questions about skills together with the skills that refine them."""

from __future__ import annotations

from collections.abc import Mapping

from companion.mission.payload_steps import Photo, PointGimbal
from companion.mission.python_call import PythonCall
from companion.mission.signals import Signal
from companion.mission.skills import Skill
from companion.mission.steps import Command, Do, Fly, Wait


def flies(skill: Skill, skills: Mapping[str, Skill]) -> bool:
    """Whether a skill, or a skill that refines it, flies to a place."""
    return _does(skill, skills, Fly)


def turns(skill: Skill, skills: Mapping[str, Skill]) -> bool:
    """Whether the companion steers the vehicle in one of the skill's steps."""
    return _does(skill, skills, (Fly, Command, Photo, PointGimbal, PythonCall, Wait))


def looks_while_holding(skill: Skill, skills: Mapping[str, Skill]) -> bool:
    """Whether the vehicle holds in a step other than one that points a gimbal."""
    return _does(skill, skills, (Command, Photo, PythonCall, Wait))


def confirming(skills: Mapping[str, Skill]) -> frozenset[Signal]:
    """The signals that confirm skills."""
    confirmed = (skill.confirmed_by for skill in skills.values())
    return frozenset(condition.signal for condition in confirmed if condition is not None)


def _does(skill: Skill, skills: Mapping[str, Skill], kinds: type | tuple[type, ...]) -> bool:
    return any(
        isinstance(step, kinds)
        or (isinstance(step, Do) and _does(skills[step.skill], skills, kinds))
        for step in skill.execute
    )
