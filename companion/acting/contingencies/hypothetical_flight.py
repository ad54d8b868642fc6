"""A hypothetical flight, at some position of its plan: what it would do about a change there.

Nothing flies, but what decides is what decides in flight: the deliberation about plans, and the
choice of a safe place. This module simulates the world around them: the vehicle is where the plan
has it, actions are completed or fail, and the change happens.

The change comes just after the next action of the plan has begun, as it would in flight, so a
flight is interrupted where it begins. What has begun on the ground is finished first.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import cast

from py_trees.behaviours import Running

from companion.acting.assembly import flight_of
from companion.acting.behaviour_tree.intention import Intention
from companion.acting.behaviour_tree.leaves import Effects, Withdraw
from companion.acting.behaviour_tree.ticked_tree import TickedTree
from companion.acting.contingencies.answers import (
    Answer,
    GoesOn,
    LandsAt,
    PlansAnew,
    StaysWhereItIs,
)
from companion.acting.contingencies.changes import (
    BeliefLost,
    Change,
    ChargeAtFloor,
    DrainUp,
    EventTurns,
    SiteLost,
)
from companion.acting.contingencies.hypothetical_charge import HypotheticalCharge
from companion.acting.contingencies.hypothetical_vehicle import HypotheticalVehicle
from companion.acting.deliberation import Deliberation, PlanChosen, PlanDecision
from companion.acting.executive_states import AwaitingPlan, Searching, WithoutPlan
from companion.acting.flight import Flight
from companion.acting.plan_under_way import LeftPlan, PlanUnderWay
from companion.acting.positions import tell_late
from companion.acting.preparation import PreparedMission
from companion.acting.replanning.assumptions import BELIEF_CAME_BACK
from companion.acting.replanning.optional_lines import drop
from companion.acting.replanning.replanner import PlanFailure
from companion.acting.safe_places import AtSafePlace, NoSafePlace, SafePlaces, WayToSafePlace
from companion.mission.events import Event
from companion.mission.facts import HERE
from companion.mission.otherwise import Otherwise
from companion.mission.steps import Land, LandOn, TakeOff
from companion.planning.charger import UNITS_PER_WH
from companion.planning.domain import Action, Refinement, Step
from companion.planning.energy.mission_energy import MissionEnergy
from companion.planning.energy_check import level_after, of_reserve, place_of
from companion.planning.explain import Explanation
from companion.planning.lasso import ChosenPlan, Lasso, Problem
from companion.tick import TICK_S
from companion.vehicle.ports.vehicle import Vehicle


class HypotheticalFlight:
    """One flight, from the beginning of a plan; it is used for one contingency.

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
        self._mission, self._planner = prepared.mission, prepared.planner
        self._routes = prepared.routes
        self._charge: HypotheticalCharge | None = None
        self._vehicle = HypotheticalVehicle(self._mission.home.position)

        def charge_of(flight: Flight, _: MissionEnergy) -> HypotheticalCharge:
            self._charge = HypotheticalCharge(flight, level or 0)
            return self._charge

        self._flight = flight = flight_of(prepared, cast(Vehicle, self._vehicle), charge_of)
        self._deliberation = Deliberation(self._planner, flight, explain=explain)
        self._lost: set[str] = set()
        self._found: set[str] = set()
        self._retry_s: float | None = None
        self._has_more_drain = False
        self._pass_time(TICK_S)
        self._deliberation.assumptions.renew()
        self.adopt(chosen)

    def adopt(self, chosen: ChosenPlan) -> None:
        """From now on flies this plan, and begins its first action."""
        drop(self._flight, chosen.dropped)
        self._lasso = chosen.lasso
        self._deliberation.adopt(chosen.lasso)
        self._begin()

    @property
    def running(self) -> Action:
        """The action of the plan that is under way."""
        actions = (*self._lasso.prefix, *self._lasso.loop)
        return actions[min(self._flight.progress.completed, len(actions) - 1)]

    def complete(self, count: int = 1, level: int | None = None) -> None:
        """Completes actions of the plan, and begins the next one.

        Args:
            count: number of actions; at most all except the last one.
            level: the level of the energy then; None for what the actions leave.
        """
        for _ in range(count):
            self._complete()
        if level is not None and self._charge is not None:
            self._charge.level = level

    def _complete(self) -> None:
        action, flight, energy = self.running, self._flight, self._planner.energy
        self._pass_time(action.cost_ms / 1000)
        Effects(flight, Intention(action.name, (action,)), ends_lap=False).update()
        if energy is not None and (charge := self._charge) is not None:
            charge.level = level_after(energy.now(is_en_route=True), charge.level, action)
        for step in _primitives(action.execute):
            if isinstance(step, Land | LandOn):
                flight.progress.take_to_ground()
            elif isinstance(step, TakeOff):
                flight.progress.leave_ground()
        self._stand_at(action)
        self._begin()

    def _pass_time(self, seconds: float) -> None:
        """Lets time pass, also for the clocks of bounded lines."""
        flight = self._flight
        flight.now_s += seconds
        flight.task.now_s = flight.now_s
        tell_late(flight)

    def _begin(self) -> None:
        """Leaves the position, as the precondition of an action does."""
        action, flight = self.running, self._flight
        flight.task.keep_dropped()
        flight.task.begin(action)
        first = next(_primitives(action.execute), None)
        if isinstance(first, Land | LandOn):
            flight.progress.take_to_ground()

    def _stand_at(self, action: Action) -> None:
        if action.destination is not None:
            self._vehicle.stand_at(self._routes.goal(action.destination))

    def meet(self, change: Change) -> tuple[Answer, ChosenPlan | None]:
        """What the flight does about a change now; and the new plan, if it makes one."""
        reason = self._take(change)
        if reason is None:
            self._finish_on_the_ground()
            reason = self._why_to_replan(change)
        if reason is None:
            return GoesOn(), None
        return self._replan(reason)

    def _take(self, change: Change) -> str | None:
        """Lets the change happen; returns why a new plan is due, if that is certain at once."""
        flight, action = self._flight, self.running
        match change:
            case EventTurns(name, holds):
                self._turn(self._mission.events[name], holds)
            case SiteLost(place):
                self._lost.add(place)
                self._routes.hide(place)
            case BeliefLost(belief):
                if belief in action.assumes:
                    return self._fail(action)
                flight.task.withdraw(frozenset({belief}))
            case ChargeAtFloor():
                if self._charge is not None and (floor := self.floor) is not None:
                    self._charge.level = floor
        return None

    @property
    def floor(self) -> int | None:
        """The lowest level allowed at the place of the flight; None if energy is ignored."""
        energy, place = self._planner.energy, place_of(self._flight.task.facts)
        if energy is None:
            return None
        return energy.now(is_en_route=True).floors.get(place or HERE)

    def _turn(self, event: Event, holds: bool) -> None:
        """Changes the event, and the place that it finds, to the middle of the place's region."""
        for name, place in self._mission.places.items():
            if holds and place.found_by == event.name:
                self._found.add(name)
                self._routes.find_place(name, place.position)
        self._flight.task.take(event, holds)
        if holds and event.is_pulse:
            self._flight.task.take(event, False)

    def _fail(self, action: Action) -> str:
        """Lets the present skill fail after all its tries; if it lands, on the ground."""
        flight = self._flight
        self._retry_s = action.retry_after_s
        Withdraw(flight, Intention(action.name, (action,)), Running("skill")).update()
        if any(isinstance(step, Land | LandOn) for step in _primitives(action.execute)):
            flight.progress.take_to_ground()
            self._stand_at(action)
            if self._charge is not None and action.charger is not None:
                self._charge.level -= action.charger.landing + action.charger.take_off
        return f"{action.name} failed"

    def _finish_on_the_ground(self) -> None:
        """Finishes what has begun on the ground; what was noticed meanwhile is answered then."""
        left = len(self._lasso.prefix) + len(self._lasso.loop) - self._flight.progress.completed
        for _ in range(left - 1):
            if not self._flight.progress.is_landed_by_plan:
                return
            self._deliberation.triggers.look(self._under_way)
            self._complete()

    @property
    def _under_way(self) -> PlanUnderWay:
        tree = TickedTree(self._flight, Running("plan"))
        return PlanUnderWay(self._lasso, tree, is_leaving=False)

    def _why_to_replan(self, change: Change) -> str | None:
        if isinstance(change, SiteLost) and self.running.destination == change.place:
            return self._fail(self.running)
        if isinstance(change, DrainUp):
            self._reckon(1 + change.share)
            return str(change)
        deliberation = self._deliberation
        if isinstance(change, BeliefLost):
            is_kept = deliberation.replanner.search_confirms(self._lasso)
            return None if is_kept else str(change)
        plan, triggers = self._under_way, deliberation.triggers
        triggers.look(plan)
        reason = triggers.before_the_tree(plan)
        while reason is None and triggers.is_thinking:
            reason = triggers.before_the_tree(plan)
        return reason or deliberation.assumptions.surprise

    def _reckon(self, factor: float) -> None:
        """From now on everything takes this multiple of what the mission says."""
        if (energy := self._planner.energy) is not None:
            energy.assume(factor)
            self._planner.reinstantiate()
            self._has_more_drain = True

    def _replan(self, reason: str) -> tuple[Answer, ChosenPlan | None]:
        """Does what the deliberation decides; a wait ends when a belief is held again."""
        self._flight.task.interrupt()
        decision = self._decided(self._deliberation.replan(reason, LeftPlan(self._lasso)))
        waits_for = decision.hopes if isinstance(decision, AwaitingPlan) else ()
        waited_s, retry_s = 0.0, self._retry_s
        if isinstance(decision, AwaitingPlan) and retry_s is not None:
            if retry_s < decision.left_s:
                waited_s, decision = retry_s, self._after_retry(decision, retry_s)
        if not isinstance(decision, PlanChosen):
            return self._without_plan(decision.failure, waits_for), None
        if decision.is_rest:
            return GoesOn(), None
        plan = decision.plan
        answer = PlansAnew(
            plan.lasso.planned,
            dropped=plan.lines_dropped,
            waited_s=waited_s,
            reserve_wh=self._of_reserve_wh(plan.lasso),
        )
        return answer, plan

    def _decided(self, decision: PlanDecision) -> PlanChosen | AwaitingPlan | WithoutPlan:
        """The decision at the end of a search."""
        while isinstance(decision, Searching):
            decision = self._deliberation.search(decision)
        return decision

    def _after_retry(
        self, waiting: AwaitingPlan, wait_s: float
    ) -> PlanChosen | AwaitingPlan | WithoutPlan:
        """The decision when a withdrawn belief is held again."""
        flight, energy = self._flight, self._planner.energy
        self._pass_time(wait_s)
        if energy is not None and self._charge is not None:
            self._charge.level -= energy.model.hovering(wait_s)
        flight.task.restore(flight.now_s, True, frozenset())
        return self._decided(self._deliberation.search_again(waiting, BELIEF_CAME_BACK))

    def _without_plan(self, failure: PlanFailure, waits_for: tuple[str, ...]) -> Answer:
        """Does what the mission says for the case that no plan exists."""
        why = str(failure).splitlines()[0]
        safe = SafePlaces(self._flight, self._planner, self._mission.safe_places)
        while (decision := safe.decide()) is None:
            pass
        match decision:
            case AtSafePlace(place):
                return LandsAt(place, why, waits_for)
            case WayToSafePlace(place):
                return LandsAt(place, why, waits_for, *self._missing_wh(safe.missing(place)))
            case NoSafePlace():
                is_hold = self._mission.otherwise is Otherwise.HOLD
                does = "holds where it is" if is_hold else "lands where it is"
                return StaysWhereItIs(does, why, not self._mission.safe_places, waits_for)

    def _of_reserve_wh(self, lasso: Lasso) -> float:
        """How much of the reserve a plan from here takes."""
        energy, facts = self._planner.energy, self._flight.task.facts
        if energy is None or not energy.charge.is_flown:
            return 0.0
        return of_reserve(energy.now(is_en_route=True), facts, lasso) / UNITS_PER_WH

    def _missing_wh(self, units: int) -> tuple[float, float]:
        """The missing energy, with the reserve left and with the reserve used."""
        energy = self._planner.energy
        reserve = 0 if energy is None else energy.model.reserve
        return units / UNITS_PER_WH, max(0, units - reserve) / UNITS_PER_WH

    def close(self) -> None:
        """Restores the mission: the next flight begins with the map as the mission gives it."""
        for name in self._lost:
            self._routes.find_place(name, self._mission.places[name].position)
        for name in self._found:
            self._routes.hide(name)
        if self._has_more_drain:
            self._reckon(1.0)
        if self._lost or self._found:
            for name, place in self._mission.places.items():
                self._routes.aim(name, place.position)
            self._planner.reinstantiate()


def _primitives(steps: tuple[Step, ...]) -> Iterator[Step]:
    for step in steps:
        if isinstance(step, Refinement):
            yield from _primitives(step.steps)
        else:
            yield step
