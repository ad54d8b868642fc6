"""Checks the skills that charge for as long as the plan says."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise

from companion.battery_profile import Points
from companion.documents import Document
from companion.errors import MissionError
from companion.mission.schema import MissionFile
from companion.mission.skill_schema import SkillEntry
from companion.mission.skills import Skill
from companion.mission.steps import Charge, Do, Execution, Fly, Land, LandOn


def charge_rate_of(
    name: str,
    entry: SkillEntry,
    execute: Sequence[Execution],
    file: MissionFile,
    document: Document,
) -> Points | None:
    """How fast a skill charges; None for a skill whose charge is not set by the plan.

    Raises:
        MissionError: the figures are impossible, or one of charge(auto), charge_rate and battery is
            missing.
    """
    places = [i for i, step in enumerate(execute) if step == Charge(None)]
    rate = entry.charge_rate
    if not places:
        if rate is not None:
            where = document.key_at("skills", name, "charge_rate")
            raise MissionError(
                f"{name} has a charge_rate and no charge(auto)",
                where,
                "add charge(auto) to execute",
            )
        return None
    where = document.where("skills", name, "execute", places[0])
    if file.battery is None:
        hint = "add battery: {reserve: 20}, or write a percentage, e.g. charge(90)"
        raise MissionError("plans know of no energy, so they say no charge", where, hint)
    if rate is None:
        hint = "add charge_rate: [[0, 2.0], [80, 2.0], [100, 0.1]], percent and percent a second"
        raise MissionError(f"it is not known how fast {name} charges", where, hint)
    is_whole = rate[0][0] == 0 and rate[-1][0] == 100 and all(0 <= c <= 100 for c, _ in rate)
    is_falling = all(a < b and v >= w for (a, v), (b, w) in pairwise(rate))
    if not is_whole or not is_falling or rate[0][1] <= 0 or rate[-1][1] < 0:
        raise MissionError(
            "the rate does not fall from [0, RATE] to [100, RATE]",
            document.where("skills", name, "charge_rate"),
            "write pairs of charge and percent a second; a battery charges the slower the fuller",
        )
    return tuple((charge / 100, rise / 100) for charge, rise in rate)


def refuse_charge_nowhere(skill: Skill, document: Document) -> None:
    """Refuses a skill that charges at an unknown place.

    Raises:
        MissionError: with the skill's place in the file.
    """
    goes_there = any(isinstance(step, Fly | Do) for step in skill.execute)
    if skill.charge_rate is not None and skill.origin is None and not goes_there:
        raise MissionError(
            f"it is not known where {skill.name} charges",
            document.key_at("skills", skill.name),
            "add precondition: at(pad), with pad one of its parameters",
        )


def refuse_charge_in_the_air(skills: Mapping[str, Skill], document: Document) -> None:
    """Refuses charging in a mission in which no skill lands.

    Raises:
        MissionError: at the step that charges.
    """
    steps = [
        (name, i, step) for name, skill in skills.items() for i, step in enumerate(skill.execute)
    ]
    if any(isinstance(step, Land | LandOn) for _, _, step in steps):
        return
    for name, index, step in steps:
        if isinstance(step, Charge):
            raise MissionError(
                f"{name} charges, and no skill lands",
                document.where("skills", name, "execute", index),
                "a battery is charged on the ground: [land(), charge(auto), take_off()]",
            )
