"""Whether the charge is enough for what is left of a plan, and for a safe place.

A gauge tells whole percents. A plan is made with the least that there may be, and is given up when
not even the most that there may be is enough, so that the gauge's steps make no plan anew. What is
not known is full, as long as it was never known; else a hover is taken from what it was last.
"""

from __future__ import annotations

import math

from companion.acting.flight import Flight
from companion.mission.facts import HERE
from companion.planning.charger import UNITS_PER_WH
from companion.planning.domain import Action
from companion.planning.energy.mission_energy import MissionEnergy
from companion.planning.energy.model import EnergyModel
from companion.planning.energy_check import required_levels
from companion.planning.lasso import Lasso
from companion.vehicle.port import Vehicle

HALF_STEP = 0.005
"""Of a gauge of whole percents."""
LOOKS_S = 1.0


class Gauge:
    """The battery as its gauge tells it.

    Args:
        vehicle: whose battery it is.
        model: in what is reckoned.
    """

    def __init__(self, vehicle: Vehicle, model: EnergyModel) -> None:
        self._vehicle, self._model = vehicle, model
        self._known, self._known_s = 1.0, math.inf

    def level(self) -> int:
        """The least that there may be, in units."""
        return self._level(-HALF_STEP)

    def most(self) -> int:
        """The most that there may be."""
        return self._level(HALF_STEP)

    def _level(self, step: float) -> int:
        state = self._vehicle.state
        if state is None:
            return self._model.level(self._known)
        if state.battery_percent is not None:
            self._known, self._known_s = state.battery_percent / 100, state.stamp_s
        taken = self._model.hovering(max(0.0, state.stamp_s - self._known_s))
        return max(0, self._model.level(min(1.0, max(0.0, self._known + step))) - taken)


class EnergyWatch:
    """Looks at the charge while a plan is flown.

    Args:
        flight: whose plan it is.
        energy: of the mission.
    """

    def __init__(self, flight: Flight, energy: MissionEnergy) -> None:
        self._flight, self._energy = flight, energy
        self._lasso: Lasso | None = None
        self._required: tuple[int, ...] = ()
        self._looked_s = -LOOKS_S

    @property
    def is_due(self) -> bool:
        """Whether it is time to look."""
        return self._flight.now_s - self._looked_s >= LOOKS_S

    def adopt(self, lasso: Lasso) -> None:
        """A plan is flown from now on, from the facts that hold now."""
        self._lasso = lasso
        facts = self._flight.task.facts
        self._required = required_levels(self._energy.now(is_en_route=True), facts, lasso)

    def shortage(self) -> str | None:
        """What is missing for the rest of the plan, in words; None if it lasts."""
        self._looked_s = self._flight.now_s
        lasso = self._lasso
        if lasso is None:
            return None
        number = self._flight.progress.completed
        ahead, following = _place(lasso, number), _place(lasso, number + 1)
        running = self._flight.task.running
        needed = self._required[ahead]
        if running is not None:
            needed = self._required[following]
            if running.charger is not None:
                needed = 0  # it is on its way down
            elif (goal := running.destination) is not None:
                needed += max(0, (self._energy.flight(HERE, goal) or 0) - self._under_way())
        missing = needed - self._energy.most()
        if missing <= 0:
            return None
        return f"{missing / UNITS_PER_WH:.1f} Wh are missing for {_name(lasso, ahead)}"

    def _under_way(self) -> int:
        """What a flight from rest takes more than one that goes on."""
        state = self._flight.vehicle.state
        return self._energy.of_speeding_up(math.hypot(*state.velocity)) if state else 0


def _place(lasso: Lasso, number: int) -> int:
    """The place, among prefix and loop, of an action by its number from the beginning on."""
    prefix = len(lasso.prefix)
    return number if number < prefix else prefix + (number - prefix) % len(lasso.loop)


def _name(lasso: Lasso, place: int) -> str:
    actions: tuple[Action, ...] = (*lasso.prefix, *lasso.loop)
    return actions[place].name
