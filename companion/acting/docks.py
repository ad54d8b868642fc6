"""The dock on which the vehicle charges: how fast it should charge, and which others there are.

The vehicle leaves a dock that charges nothing, or less than half of what the mission says, for
another dock that is believed to work and that the charge lasts for. If there is none, it stays:
nothing drains its battery on the ground, and any flight would use the energy kept for the way to a
safe place. It waits for `patience_s`, or until such a dock is believed in again.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from companion.planning.domain import Action, ends_of
from companion.planning.planner import Planner
from companion.planning.task_state import TaskState


class Dock(Protocol):
    """What a step that charges needs to know of its dock."""

    def charging_s(self, before: float, after: float) -> float:
        """The time that charging takes according to the mission.

        Args:
            before, after: charge in percent.
        """
        ...

    @property
    def patience_s(self) -> float:
        """How long the vehicle waits on a dock that charges nothing before it gives up the dock."""
        ...

    @property
    def lasts_for_another_try(self) -> bool:
        """Whether the charge, without the reserve, lasts to take off and land again."""
        ...


class AnyDock:
    """A dock unknown to plans: any charging rate is accepted, and the vehicle never waits on it."""

    patience_s = 0.0
    lasts_for_another_try = True

    def charging_s(self, before: float, after: float) -> float:
        """As long as it takes."""
        return float("inf")


@dataclass(frozen=True, slots=True)
class PlannedDock:
    """The dock of the present action.

    Attributes:
        planner: the mission's planner, with energy.
        task: tells the present action, and which docks are believed to work.
    """

    planner: Planner
    task: TaskState

    def charging_s(self, before: float, after: float) -> float:
        """By the mission's rate; unlimited for a charge without a rate."""
        energy, running = self.planner.energy, self.task.running
        if energy is None or running is None or running.charger is None:
            return float("inf")
        times_ms = running.charger.times_ms
        begin, end = (energy.model.level(min(1.0, share / 100)) for share in (before, after))
        return float(times_ms[end] - times_ms[begin]) / 1000

    @property
    def patience_s(self) -> float:
        """0 if the vehicle can fly to another dock."""
        running = self.task.running
        if running is None or running.charger is None:
            return 0.0
        docks = (
            action for action in self.planner.actions.model.actions if action.charger is not None
        )
        if any(self._is_in_reach(each) for each in docks if _dock_of(each) != _dock_of(running)):
            return 0.0
        return max(self.planner.mission.patience_s, running.retry_after_s or 0.0)

    @property
    def lasts_for_another_try(self) -> bool:
        """To land at the safe place that takes the least from here; on a dock, at that dock."""
        energy = self.planner.energy
        if energy is None:
            return True
        drains = [drain for place in energy.safe if (drain := energy.to_land_at(place)) is not None]
        needed = energy.model.reserve + energy.to_take_off() + min(drains, default=0)
        return energy.charge.least() >= needed

    def _is_in_reach(self, action: Action) -> bool:
        """Whether the vehicle may charge there, and the charge above the reserve lasts that far."""
        energy = self.planner.energy
        if energy is None or self.task.withdrawn & action.assumes:
            return False
        needed = energy.to_land_at(_dock_of(action))
        return needed is not None and energy.charge.least() >= energy.model.reserve + needed


def _dock_of(action: Action) -> str:
    """Where an action charges, whether the vehicle has to be there or it flies there itself."""
    return ends_of(action)[1] or ""
