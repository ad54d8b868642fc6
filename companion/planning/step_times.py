"""How long skills take of which nobody has said it, by their steps."""

from __future__ import annotations

from companion.mission.steps import Fly, Wait
from companion.planning.domain import Refinement, Step

ANYTHING_S = 1.0
"""What anything takes that neither flies nor waits."""


def waits_s(steps: tuple[Step, ...]) -> float:
    """How long steps wait, in all."""
    waited = 0.0
    for step in steps:
        if isinstance(step, Wait):
            waited += step.duration_s
        elif isinstance(step, Refinement):
            waited += waits_s(step.steps)
    return waited


def is_guessed(steps: tuple[Step, ...]) -> bool:
    """Whether steps do something whose time is not known: they neither fly nor wait."""
    return any(
        is_guessed(step.steps) if isinstance(step, Refinement) else not isinstance(step, Fly | Wait)
        for step in steps
    )


def on_the_spot_s(steps: tuple[Step, ...]) -> float:
    """How long a skill takes that does not fly: its waits, and a second for all else."""
    waited = waits_s(steps)
    return waited + (ANYTHING_S if is_guessed(steps) or not waited else 0.0)
