"""Decides whether a vehicle without a plan holds and looks again before it gives up.

A place that is covered for a moment, or a door that is closed for a minute, is no reason to give up
a task. So the vehicle holds for `patience_s` of the mission, if a change may make a plan possible:
a belief may come back, an event may become false, the map may change. It does not hold while an
event of the battery is true, after a violation, after a search that was given up at a limit, or if
even all of these changes would not make a plan possible.

The time counts from the first search without a plan since the last completed skill. So an event
that flaps, with a plan and without one in turn, does not keep the vehicle in the air for ever.

Only the lines of the task that may not be dropped are considered.
"""

from __future__ import annotations

from companion.acting.flight import Flight
from companion.errors import NoPlanError, SearchLimit
from companion.planning.optional_lines import without_lines
from companion.planning.planner import Planner

THE_MAP = "the map"


class Patience:
    """How long the vehicle waits for a plan.

    Attributes:
        hopes: the changes that may make a plan possible, in words; empty if there are none.

    Args:
        planner: the mission's planner.
        flight: knows what holds.
    """

    def __init__(self, planner: Planner, flight: Flight) -> None:
        self.hopes: list[str] = []
        self._planner = planner
        self._flight = flight
        self._since_s = 0.0
        self._positions = -1

    def begin(self, failure: NoPlanError | SearchLimit) -> None:
        """Notes that there is no plan, or still none, and why."""
        task = self._flight.task
        if self._positions != task.word.positions:
            self._positions, self._since_s = task.word.positions, self._flight.now_s
        is_lost = isinstance(failure, SearchLimit) or bool(task.violated)
        self.hopes = [] if is_lost else self._find_hopes()

    @property
    def left_s(self) -> float:
        """The time that is left."""
        return self._planner.mission.patience_s - (self._flight.now_s - self._since_s)

    @property
    def lasts(self) -> bool:
        """Whether the vehicle still holds and waits."""
        is_landed = self._flight.progress.is_landed_by_plan
        is_lost = bool(self._flight.task.violated)  # a clock may have run out meanwhile
        may_wait = self.left_s > 0 and bool(self.hopes) and not is_landed and not is_lost
        return may_wait and not self._is_battery_low and not self._is_charge_needed

    def _find_hopes(self) -> list[str]:
        """The changes that may come, if a search finds a plan with all of them; otherwise none."""
        task, mission = self._flight.task, self._planner.mission
        falling = {
            event.fact
            for event in mission.events.values()
            if not event.latch and event.fact in task.facts
        }
        restored = {name for event in mission.events.values() for name in event.restores}
        returning = {
            belief
            for belief in task.withdrawn
            if belief in task.beliefs.returning or belief.predicate in restored
        }
        if task.beliefs.is_cut_off or self._is_walled_in:
            return [*sorted(falling | returning), THE_MAP]
        try:
            asked = without_lines(mission.optional, *task.problem(falling, returning))
            has_plan = self._planner.solver.replan(*asked) is not None
        except SearchLimit:
            has_plan = False
        return sorted(falling | returning) if has_plan else []

    @property
    def _is_walled_in(self) -> bool:
        """Whether no place can be reached from here: then the position, or the map, is wrong."""
        state, routes = self._flight.vehicle.state, self._flight.routes
        return state is not None and not any(
            routes.is_connected(state.motion.position, place)
            for place in self._planner.mission.places
        )

    @property
    def _is_charge_needed(self) -> bool:
        """Whether landing at a safe place needs all charge except the reserve."""
        energy = self._planner.energy
        return energy is not None and energy.is_needed_to_land

    @property
    def _is_battery_low(self) -> bool:
        events = self._planner.mission.events.values()
        holding = (event for event in events if event.fact in self._flight.task.facts)
        return any(event.when.signal.is_battery for event in holding)
