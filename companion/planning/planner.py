"""The planner of one mission: everything that is made once, and a verb that plans.

Formulas are translated and skills are grounded when the planner is made. In flight only the
initial state changes (Section V, last paragraph): the facts, the automata's states after the
history, and the moves from where the vehicle is between places.
"""

from __future__ import annotations

from collections.abc import Sequence

from companion.errors import CompanionError, NoPlanError
from companion.ltl.formula import atoms, conjuncts
from companion.ltl.translate import translate
from companion.mission.model import Mission
from companion.planning.check import fault
from companion.planning.domain import Fact, FlightTime, departures, ground
from companion.planning.explain import why_no_plan
from companion.planning.lasso import Conjunct, Lasso, Letter, Problem
from companion.planning.search import find_lasso


class Planner:
    """Plans a mission from any state.

    Args:
        mission: what to do.
        flight_time: seconds between two places, or from `here` to a place; inf for no route.
    """

    def __init__(self, mission: Mission, flight_time: FlightTime) -> None:
        self.mission = mission
        self.model = ground(mission, flight_time)
        self.conjuncts = tuple(
            Conjunct(name, part, translate(part))
            for name, formula in mission.task.items()
            for part in conjuncts(formula)
        )
        self.task_facts = frozenset().union(*(atoms(c.formula) for c in self.conjuncts))
        self.flight_time = flight_time

    def problem(
        self,
        facts: frozenset[Fact],
        automaton_states: tuple[frozenset[int], ...],
        withdrawn: frozenset[Fact] = frozenset(),
        is_en_route: bool = False,
    ) -> Problem:
        """The problem from a state.

        Args:
            facts: what holds, without the beliefs.
            automaton_states: where the automata may be after reading the present position.
            withdrawn: beliefs that have been disproved; all others are held.
            is_en_route: whether the vehicle is between places: adds the moves from `here`.
        """
        actions, beliefs = self.model.actions, self.model.beliefs
        if is_en_route:
            extra = departures(self.mission, self.flight_time)
            actions = (*extra, *actions)
            beliefs = beliefs.union(*(a.assumes for a in extra))
        held = facts | (beliefs - withdrawn)
        return Problem(actions, self.conjuncts, held, automaton_states, beliefs & withdrawn)

    def plan(self, problem: Problem, histories: Sequence[Sequence[Letter]]) -> Lasso:
        """The best lasso, checked.

        Args:
            problem: from where to plan.
            histories: per conjunct, the letters that it has read.

        Raises:
            NoPlanError: there is none; the message says why.
        """
        lasso = find_lasso(problem)
        if lasso is None:
            raise NoPlanError(why_no_plan(problem))
        wrong = fault(problem, lasso, histories)
        if wrong is not None:
            raise CompanionError(f"the planner made a wrong plan, {lasso}: {wrong}")
        return lasso
