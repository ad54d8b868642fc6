"""Checks that the charge is enough for the rest of the plan, and for a safe place.

If nothing is left above the reserve, a plan leads to the safe place that takes the least. It may
use as much of the reserve as that takes, until the vehicle has charged there.

A gauge shows whole percents. A plan is made with the lowest level that is possible, and is dropped
only when not even the highest possible level is enough. So the steps of the gauge cause no replan.
A level that was never known counts as full; one that is no longer known falls by the energy of a
hover.
"""

from __future__ import annotations

import math

from companion.acting.charge.energy_meter import EnergyMeter
from companion.acting.flight import Flight
from companion.flight_events.energy import ReserveUsed
from companion.planning.charger import UNITS_PER_WH
from companion.planning.domain import Action
from companion.planning.energy.mission_energy import MissionEnergy
from companion.planning.energy_check import of_reserve, required_levels
from companion.planning.lasso import Lasso

LOOKS_S = 1.0
MORE, LESS = 0.03, 0.05
"""A replan is due if flights take this share more, or this share less."""


class EnergyWatch:
    """Checks the charge while a plan is flown.

    Args:
        flight: the flight.
        energy: the mission's energy.

    Attributes:
        meter: measures the energy of flights.
    """

    def __init__(self, flight: Flight, energy: MissionEnergy) -> None:
        self._flight, self._energy = flight, energy
        self.meter = EnergyMeter(flight, energy)
        self._lasso: Lasso | None = None
        self._required: tuple[int, ...] = ()
        self._lent = 0
        self._looked_s = -LOOKS_S

    @property
    def is_due(self) -> bool:
        """Whether it is time for a check."""
        return self._flight.now_s - self._looked_s >= LOOKS_S

    def adopt(self, lasso: Lasso) -> None:
        """Begins to check a plan, from the facts that hold now."""
        self._lasso = lasso
        facts = self._flight.task.facts
        energy = self._energy.now(is_en_route=True)
        self._required = required_levels(energy, facts, lasso)
        self._lent = of_reserve(energy, facts, lasso) if self._energy.charge.is_flown else 0
        if 0 < self._lent <= self._energy.model.reserve:
            self._flight.report(ReserveUsed(self._lent / UNITS_PER_WH))

    def shortage(self) -> str | None:
        """What is missing for the rest of the plan, in words; None if the charge is enough."""
        self._looked_s = self._flight.now_s
        lasso = self._lasso
        if lasso is None:
            return None
        number = self._flight.progress.completed
        ahead, following = _place(lasso, number), _place(lasso, number + 1)
        if self._has_charged:
            self._lent = 0
        running = self._flight.task.running
        needed = self._required[ahead]
        if running is not None:
            needed = self._required[following]
            if running.charger is not None:
                needed = 0  # it is descending already
            elif (goal := running.destination) is not None:
                needed += self._left_to(goal)
        missing = needed - self._lent - self._energy.charge.most()
        if missing <= 0:
            return None
        return f"{missing / UNITS_PER_WH:.2f} Wh are missing for {_action(lasso, ahead).name}"

    @property
    def is_figure_wrong(self) -> bool:
        """Whether plans should use other figures from now on.

        If flights take less, only if that is worth another lap, and only after a charge, which was
        for the higher figure: in the middle of a lap, another lap would repeat what was just done.
        """
        return self.takes_more or (self._ratio < 1 - LESS and self._has_charged)

    @property
    def takes_more(self) -> bool:
        """Whether flights take so much more than plans assume that the charge may not be enough."""
        return self._ratio > 1 + MORE

    @property
    def _ratio(self) -> float:
        return self._energy.known.to_plan_with / self._energy.model.factor

    @property
    def _has_charged(self) -> bool:
        """Whether the action completed last has charged."""
        number, lasso = self._flight.progress.completed, self._lasso
        if lasso is None or not number:
            return False
        return _action(lasso, _place(lasso, number - 1)).charger is not None

    def take_factor(self) -> str:
        """Makes plans use what flights really take; returns why, in words."""
        known = self._energy.known
        self._energy.use_known()
        percent = round(100 * (known.mean - 1))
        more = f"{abs(percent)} % {'less' if percent < 0 else 'more'} energy than"
        return f"flights take {more if percent else 'the energy that'} the mission says"

    def _left_to(self, goal: str) -> int:
        state = self._flight.vehicle.state
        return (self._energy.left_to(goal, math.hypot(*state.motion.velocity)) or 0) if state else 0


def _place(lasso: Lasso, number: int) -> int:
    """The place in prefix and loop of an action, from its number since the beginning."""
    prefix = len(lasso.prefix)
    return number if number < prefix else prefix + (number - prefix) % len(lasso.loop)


def _action(lasso: Lasso, place: int) -> Action:
    actions: tuple[Action, ...] = (*lasso.prefix, *lasso.loop)
    return actions[place]
