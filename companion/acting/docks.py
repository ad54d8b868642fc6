"""The dock on which the vehicle charges: how soon it should be charged, and what else there is.

A dock that gives nothing, or less than half of what the mission says of it, is left for another
one that is believed in and that the charge lasts for. Where there is none the vehicle stays: on the
ground nothing drains its battery, and any flight would take what is kept for the way to a safe
place. It waits as long as the mission waits for a plan, or until such a dock is believed in again.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from companion.planning.domain import Action
from companion.planning.energy_check import place_of
from companion.planning.planner import Planner
from companion.planning.task_state import TaskState


class Dock(Protocol):
    """What a step that charges asks."""

    def charging_s(self, before: float, after: float) -> float:
        """How long the mission says that it takes to charge.

        Args:
            before, after: percent of charge.
        """
        ...

    @property
    def patience_s(self) -> float:
        """How long the vehicle waits on a dock that gives nothing, before it gives that up."""
        ...

    @property
    def lasts_for_another_try(self) -> bool:
        """Whether the charge lasts for taking off and landing again, the reserve left."""
        ...


class AnyDock:
    """A dock of which plans know nothing: whatever it gives is enough, and nobody waits for it."""

    patience_s = 0.0
    lasts_for_another_try = True

    def charging_s(self, before: float, after: float) -> float:
        """As long as it takes."""
        return float("inf")


@dataclass(frozen=True, slots=True)
class PlannedDock:
    """The dock of the action under way.

    Attributes:
        planner: of the mission, with energy.
        task: says what is under way, and which docks are believed in.
    """

    planner: Planner
    task: TaskState

    def charging_s(self, before: float, after: float) -> float:
        """By the mission's rate; any time for a charge of which it says none."""
        energy, running = self.planner.energy, self.task.running
        if energy is None or running is None or running.charger is None:
            return float("inf")
        times_ms = running.charger.times_ms
        begin, end = (energy.model.level(min(1.0, share / 100)) for share in (before, after))
        return float(times_ms[end] - times_ms[begin]) / 1000

    @property
    def patience_s(self) -> float:
        """0 where another dock can be flown to."""
        running = self.task.running
        if running is None or running.charger is None:
            return 0.0
        docks = (action for action in self.planner.model.actions if action.charger is not None)
        if any(self._is_in_reach(action) for action in docks if action.name != running.name):
            return 0.0
        return max(self.planner.mission.patience_s, running.retry_after_s or 0.0)

    @property
    def lasts_for_another_try(self) -> bool:
        """At the safe place that takes the least from here: on a dock, that dock."""
        energy = self.planner.energy
        if energy is None:
            return True
        drains = [drain for place in energy.safe if (drain := energy.to_land_at(place)) is not None]
        needed = energy.model.reserve + energy.to_take_off() + min(drains, default=0)
        return energy.charge.least() >= needed

    def _is_in_reach(self, action: Action) -> bool:
        """Whether it may charge there, and the charge lasts for the way, the reserve left."""
        energy = self.planner.energy
        if energy is None or self.task.withdrawn & action.assumes:
            return False
        needed = energy.to_land_at(place_of(action.requires | action.adds))
        return needed is not None and energy.charge.least() >= energy.model.reserve + needed
