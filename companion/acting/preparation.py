"""Does the slow work before a run: routes, moves, automata and the first plan.

All of it depends only on the mission and on how fast the vehicle may fly, and not on messages from
the vehicle. So it is done before a run begins, where nobody waits for it, and the run's first tick
takes it over. With 20 sites it takes a second or more.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from typing import Protocol

from companion.acting.function_port import FunctionPort, NoFunctions
from companion.acting.replanning.replanner import PlanFailure
from companion.errors import NoPlanError, SearchLimit
from companion.mission.altitudes import above_ground
from companion.mission.model import Mission
from companion.motion.cost_to_go import ALL
from companion.motion.layered_routes import LayeredRoutes
from companion.motion.live_speed_limit import LiveSpeedLimit
from companion.planning.energy.mission_energy import MissionEnergy
from companion.planning.engine_port import Engine
from companion.planning.flight_times import flight_times, route_map
from companion.planning.flown_routes import FlownRoutes
from companion.planning.lasso import ChosenPlan, Lasso, Letter, Problem
from companion.planning.planner import Planner
from companion.planning.task_state import TaskState


@dataclass(frozen=True)
class FirstPlan:
    """The plan from where a mission begins.

    Attributes:
        problem: the problem that it solves.
        outcome: the plan, or why there is none.
    """

    problem: Problem
    outcome: ChosenPlan | PlanFailure


@dataclass(frozen=True, eq=False)
class PreparedMission:
    """A mission that can begin at once; its parts change in flight, so it serves one run.

    Attributes:
        first_plan: None for a behaviour tree that was written by hand.
        engine: the planner used in flight; None for the built-in search.
        engine_failure: why the engine has not made the first plan, in words.
        functions: calls functions of installed packages.
    """

    mission: Mission
    flown_routes: FlownRoutes
    speed_limit: LiveSpeedLimit
    planner: Planner
    first_plan: FirstPlan | None
    engine: Engine | None = None
    engine_failure: str | None = None
    functions: FunctionPort = field(default_factory=NoFunctions)

    @property
    def routes(self) -> LayeredRoutes:
        """The mission's routes."""
        return self.flown_routes.routes

    def plan(
        self, problem: Problem, histories: Sequence[Sequence[Letter]]
    ) -> ChosenPlan | PlanFailure:
        """The plan for the run's first problem, or why there is none.

        It is searched if the problem differs from the prepared one, because an event came before
        the start or an operator changed the speed limit.
        """
        if self.first_plan is not None and self.first_plan.problem == problem:
            return self.first_plan.outcome
        return _planned(self.planner, problem, histories)[0]


class Preparation(Protocol):
    """A mission that is being prepared for a run."""

    def done(self) -> bool:
        """Whether there is a result; it must not block."""

    def result(self) -> PreparedMission:
        """The prepared mission, once it is done.

        Raises:
            CompanionError: the mission cannot be flown.
        """


def prepare(
    mission: Mission,
    speed_max_mps: float = math.inf,
    routes: LayeredRoutes | None = None,
    engine: Engine | None = None,
    ground_amsl_m: float | None = None,
    functions: FunctionPort | None = None,
) -> PreparedMission:
    """Prepares a mission completely.

    A missing first plan is no error here; the run reports it when it begins.

    >>> from companion import load_mission
    >>> prepared = prepare(load_mission("missions/surveillance.yaml"))
    >>> print(prepared.first_plan.outcome.lasso)
    move(Home, A), (move(A, B), move(B, C), move(C, A))^w

    Args:
        mission: the mission.
        speed_max_mps: the operator's limit; one above the mission's limit changes nothing.
        routes: the mission's routes; made if None.
        engine: the planner; None for the built-in search, which also replaces a failed engine.
        ground_amsl_m: height above sea level where the vehicle stands; None while it is unknown.
        functions: calls functions of installed packages; None if there are none.

    Raises:
        CompanionError: the mission can never be flown.
    """
    calls = functions or NoFunctions()
    mission = above_ground(mission, ground_amsl_m)
    flown_routes = FlownRoutes(routes := routes or route_map(mission))
    for name in (name for name, place in mission.places.items() if place.found_by):
        routes.hide(name)
    speed_limit = LiveSpeedLimit(mission.speed_limits)
    speed_limit.set_operator_limit(speed_max_mps)
    times = flight_times(mission, flown_routes, limits=lambda: speed_limit.target)
    energy = None
    if mission.battery is not None:
        energy = MissionEnergy(mission, flown_routes, lambda: speed_limit.target)
    planner = Planner(mission, times, energy=energy)
    routes.find(ALL)  # in flight they are only repaired, which is quicker
    if mission.tree is not None:
        planner.actions.of_tree(mission.tree)  # raises an error if an action does not exist
        return PreparedMission(
            mission, flown_routes, speed_limit, planner, first_plan=None, functions=calls
        )
    problem, histories = TaskState(planner).problem()
    found, failure = _planned(planner, problem, histories, engine)
    anticipate_events(planner)
    return PreparedMission(
        mission,
        flown_routes,
        speed_limit,
        planner,
        first_plan=FirstPlan(problem, found),
        engine=engine,
        engine_failure=failure,
        functions=calls,
    )


def anticipate_events(planner: Planner) -> None:
    """Makes plans as if an event had already come, for each event.

    So the planner has the automata restricted for that event, which takes 20 ms with 100 sites,
    before the event comes in flight.
    """
    for event in planner.mission.events.values():
        task = TaskState(planner)
        task.take(event, event.fact not in task.facts)
        with suppress(SearchLimit):
            problem, histories, _ = planner.solver.kept(*task.problem())
            planner.solver.replan(problem, histories)


def _planned(
    planner: Planner,
    problem: Problem,
    histories: Sequence[Sequence[Letter]],
    engine: Engine | None = None,
) -> tuple[ChosenPlan | PlanFailure, str | None]:
    """The plan, or why there is none; and why the engine, if any, has not made it."""
    problem, histories, dropped = planner.solver.kept(problem, histories)
    answer = engine.plan(problem, histories) if engine is not None else None
    if isinstance(answer, Lasso):
        return ChosenPlan(answer, dropped), None
    reason = answer.reason if answer is not None else None
    try:
        return ChosenPlan(planner.solver.solve(problem, histories).lasso, dropped), reason
    except (NoPlanError, SearchLimit) as failure:
        return failure, reason
