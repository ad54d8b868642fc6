"""A hypothetical flight: the vehicle is where the plan has it, actions are completed or fail.

Nothing flies. At some position of the plan something changes (changes.py); `reaction.py` says what
the flight does about it. The change comes just after the next action of the plan has begun, as it
would in flight, so a flight is interrupted where it begins.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

from py_trees.behaviours import Running

from companion.acting.assembly import flight_of
from companion.acting.behaviour_tree.intention import Intention
from companion.acting.behaviour_tree.leaves import Effects, Withdraw
from companion.acting.behaviour_tree.ticked_tree import TickedTree
from companion.acting.contingencies.changes import (
    BeliefLost,
    Change,
    ChargeAtFloor,
    EventTurns,
    SiteLost,
)
from companion.acting.contingencies.hypothetical_charge import HypotheticalCharge
from companion.acting.contingencies.hypothetical_vehicle import HypotheticalVehicle
from companion.acting.deliberation import Deliberation
from companion.acting.flight import Flight
from companion.acting.plan_under_way import TaskPlan
from companion.acting.positions import tell_late
from companion.acting.preparation import PreparedMission
from companion.acting.replanning.optional_lines import drop
from companion.mission.events import Event
from companion.mission.facts import HERE
from companion.mission.steps import Land, LandOn, TakeOff
from companion.planning.domain import Action, Refinement, Step
from companion.planning.energy.mission_energy import MissionEnergy
from companion.planning.energy_check import level_after, place_of
from companion.planning.explain import Explanation
from companion.planning.lasso import ChosenPlan, Problem
from companion.tick import TICK_S


class HypotheticalFlight:
    """One flight, from the beginning of a plan; it is used for one contingency.

    Attributes:
        mission: the mission.
        planner: its planner.
        flight: the flight, whose vehicle stands still in the air.
        deliberation: decides about its plans.
        lasso: the plan that is flown.
        charge: of its battery; None if energy is ignored.
        retry_s: how long after a failure a belief is held again; None for never, or no failure.

    Args:
        prepared: the mission; `close` restores its routes and actions.
        chosen: the plan.
        level: of the energy at its beginning; None if energy is ignored.
        explain: explains why a problem has no plan; None for the planner's own explanation.
    """

    def __init__(
        self,
        prepared: PreparedMission,
        chosen: ChosenPlan,
        level: int | None,
        explain: Callable[[Problem], Explanation] | None = None,
    ) -> None:
        self.mission, self.planner = prepared.mission, prepared.planner
        self._routes = prepared.routes
        self.charge: HypotheticalCharge | None = None
        self._vehicle = HypotheticalVehicle(self.mission.home.position)

        def charge_of(flight: Flight, _: MissionEnergy) -> HypotheticalCharge:
            self.charge = HypotheticalCharge(flight, level or 0)
            return self.charge

        self.flight = flight = flight_of(prepared, self._vehicle, charge_of)
        self.deliberation = Deliberation(self.planner, flight, explain=explain)
        self._lost: set[str] = set()
        self._found: set[str] = set()
        self.retry_s: float | None = None
        self._has_more_drain = False
        self.pass_time(TICK_S)
        self.deliberation.assumptions.renew()
        self.adopt(chosen)

    def adopt(self, chosen: ChosenPlan) -> None:
        """From now on flies this plan, and begins its first action."""
        drop(self.flight, chosen.dropped)
        self.lasso = chosen.lasso
        self.deliberation.adopt(chosen.lasso)
        self._begin()

    @property
    def running(self) -> Action:
        """The action of the plan that is under way."""
        actions = (*self.lasso.prefix, *self.lasso.loop)
        return actions[min(self.flight.progress.completed, len(actions) - 1)]

    def complete(self, count: int = 1, level: int | None = None) -> None:
        """Completes actions of the plan, and begins the next one.

        Args:
            count: number of actions; at most all except the last one.
            level: the level of the energy then; None for what the actions leave.
        """
        for _ in range(count):
            self._complete()
        if level is not None and self.charge is not None:
            self.charge.level = level

    def _complete(self) -> None:
        action, flight, energy = self.running, self.flight, self.planner.energy
        self.pass_time(action.cost_ms / 1000)
        Effects(flight, Intention(action.name, (action,)), ends_lap=False).update()
        if energy is not None and (charge := self.charge) is not None:
            charge.level = level_after(energy.now(is_en_route=True), charge.level, action)
        for step in _primitives(action.execute):
            if isinstance(step, Land | LandOn):
                flight.progress.take_to_ground()
            elif isinstance(step, TakeOff):
                flight.progress.leave_ground()
        self._stand_at(action)
        self._begin()

    def pass_time(self, seconds: float) -> None:
        """Lets time pass, also for the clocks of bounded lines."""
        flight = self.flight
        flight.now_s += seconds
        flight.task.word.now_s = flight.now_s
        tell_late(flight)

    def _begin(self) -> None:
        """Leaves the position, as the precondition of an action does."""
        action, flight = self.running, self.flight
        flight.task.keep_dropped()
        flight.task.begin(action)
        first = next(_primitives(action.execute), None)
        if isinstance(first, Land | LandOn):
            flight.progress.take_to_ground()

    def _stand_at(self, action: Action) -> None:
        if action.destination is not None:
            self._vehicle.stand_at(self._routes.goal(action.destination))

    def take(self, change: Change) -> str | None:
        """Lets the change happen; returns why a new plan is due, if that is certain at once."""
        flight, action = self.flight, self.running
        match change:
            case EventTurns(name, holds):
                self._turn(self.mission.events[name], holds)
            case SiteLost(place):
                self._lost.add(place)
                self._routes.hide(place)
            case BeliefLost(belief):
                if belief in action.assumes:
                    return self.fail(action)
                flight.task.withdraw(frozenset({belief}))
            case ChargeAtFloor():
                if self.charge is not None and (floor := self.floor) is not None:
                    self.charge.level = floor
        return None

    @property
    def floor(self) -> int | None:
        """The lowest level allowed at the place of the flight; None if energy is ignored."""
        energy, place = self.planner.energy, place_of(self.flight.task.facts)
        if energy is None:
            return None
        return energy.now(is_en_route=True).floors.get(place or HERE)

    def _turn(self, event: Event, holds: bool) -> None:
        """Changes the event, and the place that it finds, to the middle of the place's region."""
        for name, place in self.mission.places.items():
            if holds and place.found_by == event.name:
                self._found.add(name)
                self._routes.find_place(name, place.position)
        self.flight.task.take(event, holds)
        if holds and event.is_pulse:
            self.flight.task.take(event, False)

    def fail(self, action: Action) -> str:
        """Lets the present skill fail after all its tries; if it lands, on the ground."""
        flight = self.flight
        self.retry_s = action.retry_after_s
        Withdraw(flight, Intention(action.name, (action,)), Running("skill")).update()
        if any(isinstance(step, Land | LandOn) for step in _primitives(action.execute)):
            flight.progress.take_to_ground()
            self._stand_at(action)
            if self.charge is not None and action.charger is not None:
                self.charge.level -= action.charger.landing + action.charger.take_off
        return f"{action.name} failed"

    def finish_on_the_ground(self) -> None:
        """Finishes what has begun on the ground; what was noticed meanwhile is answered then."""
        left = len(self.lasso.prefix) + len(self.lasso.loop) - self.flight.progress.completed
        for _ in range(left - 1):
            if not self.flight.progress.is_landed_by_plan:
                return
            self.deliberation.triggers.look(self.under_way)
            self._complete()

    @property
    def under_way(self) -> TaskPlan:
        """The plan, as the triggers see it."""
        return TaskPlan(self.lasso, TickedTree(self.flight, Running("plan")))

    def scale_energy(self, factor: float) -> None:
        """From now on everything takes this multiple of what the mission says."""
        if (energy := self.planner.energy) is not None:
            energy.assume(factor)
            self.planner.reinstantiate()
            self._has_more_drain = True

    def close(self) -> None:
        """Restores the mission: the next flight begins with the map as the mission gives it."""
        for name in self._lost:
            self._routes.find_place(name, self.mission.places[name].position)
        for name in self._found:
            self._routes.hide(name)
        if self._has_more_drain:
            self.scale_energy(1.0)
        if self._lost or self._found:
            for name, place in self.mission.places.items():
                self._routes.aim(name, place.position)
            self.planner.reinstantiate()


def _primitives(steps: tuple[Step, ...]) -> Iterator[Step]:
    for step in steps:
        if isinstance(step, Refinement):
            yield from _primitives(step.steps)
        else:
            yield step
