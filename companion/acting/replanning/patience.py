"""Whether a vehicle without a plan holds for a while, and looks again, before it gives up.

A place that is covered for a moment, or a door that is closed for a minute, is no reason to leave a
task. So the vehicle holds for `patience_s` of the mission where something may change that its plan
depends on: a belief that comes back, an event that can fall, the map. It does not hold where time
is short or lost: while an event of the battery holds, after a violation, where the search was given
up at a limit, and where there would be no plan either if all of that had changed.

The time counts from the first look without a plan since a skill was completed. So an event that
flaps between a plan and none does not keep the vehicle in the air for ever.

All of it is about the lines of the task that are never dropped.
"""

from __future__ import annotations

import math

from companion.acting.flight import Flight
from companion.errors import NoPlanError, SearchLimit
from companion.flight_events.plans import PlanAwaited
from companion.motion.heading import glance
from companion.planning.optional_lines import without_lines
from companion.planning.planner import Planner

THE_MAP = "the map"
APART_S = 2.0
"""Holds so far apart, with no search between them, are two waits; the second looks elsewhere."""


class Patience:
    """How long a plan is waited for.

    Attributes:
        hopes: what may change so that there is a plan, in words; none where nothing can.

    Args:
        planner: of the mission.
        flight: knows what holds.
    """

    def __init__(self, planner: Planner, flight: Flight) -> None:
        self.hopes: list[str] = []
        self._planner = planner
        self._flight = flight
        self._since_s = 0.0
        self._positions = -1
        self._heading_rad = 0.0
        self._facing_s = 0.0
        self._held_s = -math.inf

    def tell(self, failure: NoPlanError | SearchLimit) -> None:
        """The vehicle begins to wait, and tells why."""
        why = str(failure).splitlines()[0]
        self._flight.report(PlanAwaited(why, round(self.left_s, 1), ", ".join(self.hopes)))

    def hold(self) -> None:
        """Holds for a tick; where the map may change, the vehicle looks to and fro.

        Beams of a range finder that stands still pass by most of a door 5 m away, and what they do
        not pass stays as it was seen last.
        """
        flight = self._flight
        if THE_MAP not in self.hopes:
            flight.guidance.hold()
            return
        if flight.now_s - self._held_s > APART_S:
            self._heading_rad, self._facing_s = flight.guidance.heading_rad, flight.now_s
        self._held_s = flight.now_s
        flight.guidance.hold(self._heading_rad + glance(flight.now_s - self._facing_s))

    def begin(self, failure: NoPlanError | SearchLimit) -> None:
        """There is no plan, or still none; why."""
        task = self._flight.task
        if self._positions != task.positions:
            self._positions, self._since_s = task.positions, self._flight.now_s
        is_lost = isinstance(failure, SearchLimit) or bool(task.violated)
        self.hopes = [] if is_lost else self._find_hopes()

    @property
    def left_s(self) -> float:
        """How much of it is left."""
        return self._planner.mission.patience_s - (self._flight.now_s - self._since_s)

    @property
    def lasts(self) -> bool:
        """Whether the vehicle holds."""
        is_landed = self._flight.progress.is_landed_by_plan
        is_lost = bool(self._flight.task.violated)  # a clock may have run over meanwhile
        may_wait = self.left_s > 0 and bool(self.hopes) and not is_landed and not is_lost
        return may_wait and not self._is_battery_low and not self._is_charge_needed

    def _find_hopes(self) -> list[str]:
        """What may change, if there is a plan with all of it, as far as a search can tell."""
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
            if belief in task.returning or belief.predicate in restored
        }
        if task.is_cut_off or self._is_walled_in:
            return [*sorted(falling | returning), THE_MAP]
        try:
            asked = without_lines(mission.optional, *task.problem(falling, returning))
            has_plan = self._planner.solver.replan(*asked) is not None
        except SearchLimit:
            has_plan = False
        return sorted(falling | returning) if has_plan else []

    @property
    def _is_walled_in(self) -> bool:
        """Whether no place can be reached from here: the position, or the map, is wrong."""
        state, routes = self._flight.vehicle.state, self._flight.routes
        return state is not None and not any(
            routes.is_connected(state.position, place) for place in self._planner.mission.places
        )

    @property
    def _is_charge_needed(self) -> bool:
        """Whether all charge but the reserve is needed to land at a safe place."""
        energy = self._planner.energy
        return energy is not None and energy.is_needed_to_land

    @property
    def _is_battery_low(self) -> bool:
        events = self._planner.mission.events.values()
        holding = (event for event in events if event.fact in self._flight.task.facts)
        return any(event.when.signal.is_battery for event in holding)
