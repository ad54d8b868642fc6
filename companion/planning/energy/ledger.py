"""The energy of a plan, step by step, for people.

The plan is simulated from the present level, laps until one equals the one before. Percents are of
the charge, as a gauge shows it.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import chain, cycle

from companion.mission.facts import Fact
from companion.mission.steps import Charge
from companion.planning.charger import UNITS_PER_WH
from companion.planning.domain import WAIT, Action, Refinement, Step
from companion.planning.energy_check import place_of, required_levels
from companion.planning.lasso import Energy, Lasso, Problem


@dataclass(frozen=True, slots=True)
class PlannedEnergy:
    """The energy of one action of a plan.

    Attributes:
        takes_wh: the energy that it takes; None for a charge, and for rest on the ground.
        required_percent: the charge required before it, so that the plan can go on.
        charge_to_percent: the charge to which it charges; None if it does not charge.
    """

    takes_wh: float | None
    required_percent: int
    charge_to_percent: int | None

    def as_json(self) -> dict[str, object]:
        """The same as JSON data."""
        return {
            "takes_wh": self.takes_wh,
            "required_percent": self.required_percent,
            "charge_to_percent": self.charge_to_percent,
        }

    def __str__(self) -> str:
        if self.charge_to_percent is not None:
            return f"charges to {self.charge_to_percent} %"
        return "" if self.takes_wh is None else f"{self.takes_wh:.2f} Wh"


@dataclass(frozen=True, slots=True)
class Ledger:
    """The energy of a plan.

    Attributes:
        prefix, loop: the energy of each action.
        lap_wh: energy of a lap, including landings and take-offs for charges; 0 for rest.
        least_percent: the lowest charge of the whole plan.
        least_at: where that is, in words.
        reserve_percent: the charge kept for what nobody foresees.
    """

    prefix: tuple[PlannedEnergy, ...]
    loop: tuple[PlannedEnergy, ...]
    lap_wh: float
    least_percent: float
    least_at: str
    reserve_percent: float

    def __str__(self) -> str:
        least = f"{self.least_percent:.1f} % are left at least, {self.least_at}"
        return f"{least}; the reserve is {self.reserve_percent:.1f} %"

    def as_json(self) -> dict[str, object]:
        """The plan as a whole, as `companion plan --json` prints it."""
        return {
            "lap_wh": self.lap_wh,
            "least_percent": round(self.least_percent, 1),
            "least_at": self.least_at,
            "reserve_percent": round(self.reserve_percent, 1),
        }


def ledger(problem: Problem, lasso: Lasso, reserve: int) -> Ledger:
    """The energy of a plan.

    Args:
        problem: the problem that it solves, with energy.
        lasso: the plan.
        reserve: units kept for what nobody foresees.
    """
    energy = problem.energy
    assert energy is not None
    required = required_levels(energy, problem.facts, lasso)
    actions = (*lasso.prefix, *lasso.loop)
    steps = [
        _planned(energy, action, level, lasso)
        for action, level in zip(actions, required, strict=True)
    ]
    cut = len(lasso.prefix)
    lap_wh = 0.0 if lasso.ends_at_rest else sum(map(_taken, lasso.loop)) / UNITS_PER_WH
    least, where = min(_levels(energy, problem.facts, lasso, reserve), key=lambda each: each[0])
    return Ledger(
        prefix=tuple(steps[:cut]),
        loop=tuple(steps[cut:]),
        lap_wh=lap_wh,
        least_percent=_percent(energy, least),
        least_at=where,
        reserve_percent=_percent(energy, reserve),
    )


def _planned(energy: Energy, action: Action, required: int, lasso: Lasso) -> PlannedEnergy:
    is_on_ground = action is WAIT and lasso.ends_at_rest
    units = energy.rest if action is WAIT else action.drain
    takes_wh = None if action.charger is not None or is_on_ground else units / UNITS_PER_WH
    percent = math.ceil(_percent(energy, required))
    return PlannedEnergy(takes_wh, percent, _charged_to(action.execute))


def _charged_to(steps: Sequence[Step]) -> int | None:
    """The percentage of the first step that charges, including steps of skills that it calls."""
    for step in steps:
        inner = _charged_to(step.steps) if isinstance(step, Refinement) else None
        if inner is not None:
            return inner
        if isinstance(step, Charge) and step.percent is not None:
            return math.ceil(step.percent)
    return None


def _taken(action: Action) -> int:
    charger = action.charger
    return action.drain if charger is None else charger.landing + charger.take_off


def _percent(energy: Energy, level: int) -> float:
    return energy.percents[min(max(0, level), len(energy.percents) - 1)]


def _levels(
    energy: Energy, facts: frozenset[Fact], lasso: Lasso, reserve: int
) -> Iterator[tuple[int, str]]:
    """The level after each action, and after each landing, with the place in words."""
    level, begun = energy.level, -1
    yield level, "at the beginning"
    for number, action in enumerate(chain(lasso.prefix, cycle(lasso.loop)), -len(lasso.prefix)):
        if number >= 0 and lasso.ends_at_rest:
            place = place_of(facts)
            yield level - (energy.rests.get(place, reserve) - reserve), f"on the ground at {place}"
            return
        if number >= 0 and number % len(lasso.loop) == 0:  # a lap begins
            if 0 <= begun <= level:
                return
            begun = level
        facts = action.apply(facts)
        charger, place = action.charger, place_of(facts)
        if charger is not None and action.charge_to is not None:
            landed = level - charger.landing
            yield landed, f"on the ground at {place}"
            level = max(action.charge_to, landed - charger.take_off)
        else:
            level -= energy.rest if action is WAIT else action.drain
            yield level, f"at {place}"
