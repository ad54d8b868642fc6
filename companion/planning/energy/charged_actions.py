"""Actions that charge to the level that a plan says."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

from companion.mission.steps import Charge
from companion.planning.domain import Action, Refinement, Step

GAUGE_PERCENT = 1
"""The error of a gauge that shows whole percents."""


def charged(action: Action, level: int, arrival: int | None, percents: Sequence[float]) -> Action:
    """An action that charges so far that a certain level is left after taking off.

    Args:
        action: an action with a charger.
        level: the level after taking off.
        arrival: the level before the action; None for the lowest possible one.
        percents: by level, the charge of the battery.
    """
    assert action.charger is not None
    charger = action.charger
    full = len(percents) - 1
    percent = min(100, math.ceil(percents[min(level + charger.take_off, full)]) + GAUGE_PERCENT)
    cost_ms = charger.service_ms(charger.floor if arrival is None else arrival, level)
    called = None
    if charger.called is not None:
        called = math.ceil(percents[min(charger.called, full)])
    steps = tuple(_charging(step, Charge(percent, called)) for step in action.execute)
    enough = math.ceil(percents[min(level, full)]) + GAUGE_PERCENT
    stop = Refinement(f"charge to {percent} %", steps, 1, None, enough_percent=enough)
    return replace(action, execute=(stop,), cost_ms=cost_ms, charge_to=level)


def _charging(step: Step, charge: Charge) -> Step:
    if isinstance(step, Charge) and step.percent is None:
        return charge
    if isinstance(step, Refinement):
        return replace(step, steps=tuple(_charging(each, charge) for each in step.steps))
    return step
