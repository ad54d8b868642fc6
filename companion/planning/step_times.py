"""Estimates how long skills take from their steps, if nobody has said it."""

from __future__ import annotations

from companion.mission.steps import Fly, Wait
from companion.planning.domain import Refinement, Step

ANYTHING_S = 1.0
"""Assumed duration of a step that neither flies nor waits."""


def waits_s(steps: tuple[Step, ...]) -> float:
    """Total waiting time of some steps."""
    waited = 0.0
    for step in steps:
        if isinstance(step, Wait):
            waited += step.duration_s
        elif isinstance(step, Refinement):
            waited += waits_s(step.steps)
    return waited


def is_guessed(steps: tuple[Step, ...]) -> bool:
    """Whether some step has an unknown duration: it neither flies nor waits."""
    return any(
        is_guessed(step.steps) if isinstance(step, Refinement) else not isinstance(step, Fly | Wait)
        for step in steps
    )


def on_the_spot_s(steps: tuple[Step, ...]) -> float:
    """Duration of a skill that does not fly: its waits, and a second for each other step."""
    waited = waits_s(steps)
    return waited + (ANYTHING_S if is_guessed(steps) or not waited else 0.0)
