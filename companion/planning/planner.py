"""The planner of one mission: holds what is made once, and offers the functions that plan.

`plan` and `explain` answer before a flight, from the mission's first state or from another one. In
flight, the task's state makes problems (task_state.py), and `solver` is asked for their plans.

Formulas are translated and skills are instantiated when the planner is made. In flight only the
initial state changes (Section V, last paragraph): the facts, the states of the automata after the
history, and the moves from `here`. When the map changes, so do the actions (mission_actions.py).
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace

from companion.arguments import check_kind
from companion.errors import CompanionError, RequestError
from companion.ltl.monitor import Runs
from companion.mission.facts import Fact
from companion.mission.model import Mission
from companion.planning.bound_clocks import NO_CLOCKS, begun
from companion.planning.builtin.masked_actions import KnownActions
from companion.planning.builtin.product import Product
from companion.planning.builtin.transition_system import TransitionSystem
from companion.planning.energy.ledger import Ledger, ledger
from companion.planning.energy.mission_energy import MissionEnergy
from companion.planning.energy_check import place_of
from companion.planning.explain import Explanation, NoPlan
from companion.planning.flight_times import flight_times, given_times, route_map
from companion.planning.flown_routes import FlownRoutes
from companion.planning.instances import FlightTime
from companion.planning.lasso import Lasso, Letter, Problem, Solution
from companion.planning.mission_actions import MissionActions
from companion.planning.objective import Encoding, Objective, asked_for
from companion.planning.optional_lines import without_lines
from companion.planning.readiness import Readiness, ready_lines
from companion.planning.skill_trials import UNTRIED, SkillTrials
from companion.planning.solver import Solver
from companion.planning.supposition import supposed_facts, supposed_withdrawn
from companion.planning.task_automata import translated
from companion.planning.unread_rises import UnreadRises

BUILT_IN = "built-in"
"""The engine that plans unless another one is named."""

log = logging.getLogger(__name__)


class Planner:
    """Plans a mission from any state.

    >>> from companion import Planner, load_mission
    >>> planner = Planner(load_mission("missions/surveillance.yaml"))
    >>> [action.name for action in planner.plan().loop]
    ['move(A, B)', 'move(B, C)', 'move(C, A)']
    >>> print(planner.plan(at="r1", facts={"targetFound"}))
    upload(r1), move(r1, Home), (wait)^w

    Args:
        mission: the mission.
        flight_time: seconds between two places, or from `here` to a place; inf without a route. A
            function, or a table from pairs of places to seconds; pairs without a route are left
            out. By default, the times of flight on the mission's map.
        clock: seconds; used to measure `translating_s` and `instantiating_s`.
        energy: of a mission with a battery; made if absent, but not with given flight times.

    Raises:
        CompanionError: it is no mission; or it has a battery, flight times but no energy.

    Attributes:
        solver: solves the problems that `problem` and `initial_problem` make.
        actions: of the mission, as they are now.
    """

    def __init__(
        self,
        mission: Mission,
        flight_time: FlightTime | Mapping[tuple[str, str], float] | None = None,
        clock: Callable[[], float] = lambda: 0.0,
        energy: MissionEnergy | None = None,
    ) -> None:
        check_kind(mission, Mission, "a mission, as of load_mission")
        if flight_time is None:
            flown_routes = FlownRoutes(route_map(mission))
            flight_time = flight_times(mission, flown_routes)
            if mission.battery is not None:
                energy = energy or MissionEnergy(mission, flown_routes)
        elif mission.battery is not None and energy is None:
            raise RequestError(
                "flight times say nothing of energy, and the mission has a battery\n"
                "    leave out flight_time, or the mission's battery"
            )
        else:
            flight_time = given_times(mission, flight_time)
        self.mission = mission
        start_s = clock()
        self.energy = energy
        self.actions = MissionActions(mission, flight_time, energy)
        self.instantiating_s = clock() - start_s
        self.conjuncts = tuple(translated(mission))
        self.translating_s = clock() - start_s - self.instantiating_s
        self.task_facts = mission.task_facts
        self._readiness = Readiness(ready_lines(mission))
        self.solver = Solver(mission, self.actions.model.actions)
        self._unread_rises = UnreadRises()
        model = self.actions.model
        log.debug("%d actions, %d beliefs", len(model.actions), len(model.beliefs))
        if self.translating_s:  # it was measured
            times_ms = 1000 * self.instantiating_s, 1000 * self.translating_s
            log.debug("instantiated in %.1f ms, translated in %.1f ms", *times_ms)

    def reinstantiate(self) -> None:
        """Applies changed flight times."""
        self.actions.reinstantiate()
        self.solver.take_actions(self.actions.model.actions)

    @property
    def energy_factor(self) -> float:
        """By which factor plans assume more drain than the mission; 1 without a battery."""
        return 1.0 if self.energy is None else self.energy.model.factor

    def problem(
        self,
        facts: frozenset[Fact],
        automaton_states: tuple[frozenset[int], ...],
        withdrawn: frozenset[Fact] = frozenset(),
        is_en_route: bool = False,
        unread: frozenset[Fact] = frozenset(),
        clocks_ms: tuple[int | None, ...] = NO_CLOCKS,
        trials: SkillTrials = UNTRIED,
    ) -> Problem:
        """The planning problem in a given state.

        Args:
            facts: what holds, without the beliefs.
            automaton_states: possible states of the automata after reading the present position.
            withdrawn: beliefs that were disproved; all others are held.
            is_en_route: whether the vehicle is between places; if so, adds the moves from `here`.
            unread: events that have risen and fallen since the last letter was read.
            clocks_ms: per conjunct, what its clock shows after reading it; () without bounds.
            trials: what is known of the skills from trying them.
        """
        actions, beliefs = self.actions.model.actions, self.actions.model.beliefs
        if is_en_route:
            extra = self.actions.departures()
            actions, beliefs = (*actions, *extra), beliefs.union(*(a.assumes for a in extra))
        actions = trials.usable(actions)
        held = facts | (beliefs - withdrawn)
        every, energy = actions, None
        actions = self._readiness.allowed(every, withdrawn)
        if self.energy is not None:
            now = self.energy.now(is_en_route)
            actions, energy = self._readiness.on_battery(actions, now, withdrawn)
            energy = self.energy.with_reserve(energy, place_of(held), actions)
        problem = Problem(actions, self.conjuncts, held, automaton_states, beliefs & withdrawn)
        problem = replace(problem, clocks_ms=clocks_ms, energy=energy, barred=trials.barred)
        if self._readiness.lines:
            problem = replace(problem, with_ruled_out=every)
        return self._unread_rises.with_unread(problem, unread) if unread else problem

    def plan(
        self,
        *,
        at: str | None = None,
        facts: Iterable[str] = (),
        without: Iterable[str] = (),
        objective: Objective | str = Objective.LAP,
        engine: str = BUILT_IN,
        encoding: Encoding | str = Encoding.V4,
        timeout_s: float = 60.0,
    ) -> Solution:
        """The best plan from the mission's first state, or from one that differs from it.

        Lines of the task that have a priority are dropped if a plan cannot keep all of them.

        >>> from companion import Planner, load_mission
        >>> planner = Planner(load_mission("missions/surveillance.yaml"))
        >>> print(planner.plan(at="r1", facts={"targetFound"}, without={"canUpload(r1)"}))
        move(r1, r2), upload(r2), move(r2, Home), (wait)^w

        Args:
            at: the place of the vehicle; by default, where the mission begins.
            facts: further facts that hold, e.g. `{"targetFound"}`; `"!loaded"` means not loaded.
            without: beliefs that are withdrawn, e.g. `{"canUpload(r1)"}`.
            objective: what is minimised; also by name: `lap`, `sum` or `bottleneck`.
            engine: `built-in`, or the name of an engine of unified-planning.
            encoding: how the problem is compiled for another engine.
            timeout_s: time limit of another engine.

        Raises:
            NoPlan: there is none; its `explanation` says why.
            MissionError: the mission does not know one of the names.
            SearchLimit: the search was given up, so it is not known whether there is a plan.
            CompanionError: the engine failed, or there is no such objective or encoding.
        """
        objective, encoding = asked_for(objective, encoding)
        asked = self.initial_problem(at=at, facts=facts, without=without)
        problem, histories, dropped = self.solver.kept(*asked)
        if engine == BUILT_IN:
            return replace(self.solver.solve(problem, histories, objective), dropped=dropped)
        from companion.planning.engines import solve_with

        found = solve_with(problem, histories, engine, encoding, objective, timeout_s)
        if found is None:
            best = self.solver.solve(problem, histories, objective)  # or says why there is none
            raise CompanionError(f"{engine} says that there is no plan, but there is: {best.lasso}")
        return replace(found, dropped=dropped)

    def ledger(self, problem: Problem, lasso: Lasso) -> Ledger | None:
        """What a plan takes from the battery; None for a mission without one."""
        energy = self.energy
        return None if energy is None else ledger(problem, lasso, energy.model.reserve)

    def explain(
        self, *, at: str | None = None, facts: Iterable[str] = (), without: Iterable[str] = ()
    ) -> Explanation | None:
        """Why there is no plan from a state as in `plan`; None if there is one.

        Only the lines of the task that are never dropped are considered.

        >>> from companion import Planner, load_mission
        >>> planner = Planner(load_mission("missions/surveillance.yaml"))
        >>> refused = {"canUpload(r1)", "canUpload(r2)", "canUpload(r3)"}
        >>> why = planner.explain(facts={"targetFound"}, without=refused)
        >>> [conjunct.name for conjunct in why.conflict], [str(u.fact) for u in why.unreachable]
        (['upload'], ['targetReported'])
        >>> planner.explain() is None
        True

        Raises:
            MissionError: the mission does not know one of the names.
            SearchLimit: the search was given up, so it is not known whether there is a plan.
        """
        asked = self.initial_problem(at=at, facts=facts, without=without)
        try:
            next(self.solver.solutions(*without_lines(self.mission.optional, *asked)))
        except NoPlan as reason:
            return reason.explanation
        return None

    def transition_system(
        self, *, at: str | None = None, facts: Iterable[str] = (), without: Iterable[str] = ()
    ) -> TransitionSystem:
        """The states that actions lead to, from a state as in `plan`.

        >>> from companion import Planner, load_mission
        >>> planner = Planner(load_mission("missions/surveillance.yaml"))
        >>> graph = planner.transition_system().to_networkx()
        >>> graph.number_of_nodes(), graph.number_of_edges()
        (7, 49)

        Raises:
            MissionError: the mission does not know one of the names.
        """
        problem, _ = self.initial_problem(at=at, facts=facts, without=without)
        return TransitionSystem(problem.actions, problem.facts, KnownActions())

    def product(
        self, *, at: str | None = None, facts: Iterable[str] = (), without: Iterable[str] = ()
    ) -> Product:
        """The transition system and the automata together, explored from a state as in `plan`.

        The automata are those of the lines that a plan keeps.

        >>> from companion import Planner, load_mission
        >>> planner = Planner(load_mission("missions/surveillance.yaml"))
        >>> graph = planner.product(at="r1", facts={"targetFound"}).to_networkx()
        >>> graph.nodes[0]["facts"], graph.graph["conjuncts"][-1]
        (frozenset({'at(r1)'}), 'G(targetReported -> X at(Home))')

        Raises:
            MissionError: the mission does not know one of the names.
            SearchLimit: the product has too many states.
        """
        problem, *_ = self.solver.kept(*self.initial_problem(at=at, facts=facts, without=without))
        return self.solver.product(problem)

    def initial_problem(
        self, *, at: str | None = None, facts: Iterable[str] = (), without: Iterable[str] = ()
    ) -> tuple[Problem, list[list[Letter]]]:
        """The problem in the first state or in one that differs, and what each conjunct has read.

        Its arguments are those of `plan`.

        Raises:
            MissionError: the mission does not know one of the names.
        """
        state = supposed_facts(self.mission, self.actions.model, at, facts)
        withdrawn = supposed_withdrawn(self.actions.model, without)
        letter = state | (self.actions.model.beliefs - withdrawn)
        runs = (Runs.begin(conjunct.automaton).after(letter) for conjunct in self.conjuncts)
        states, clocks_ms = tuple(run.states for run in runs), begun(self.conjuncts, letter)
        problem = self.problem(state, states, withdrawn, clocks_ms=clocks_ms)
        return problem, [[letter] for _ in self.conjuncts]
