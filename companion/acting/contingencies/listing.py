"""Lists the contingencies of a plan, and finds the answer to each.

At each position of the first plan there is one for each event of the mission, each belief that the
plan assumes, each place, and, with a battery, for more drain and for a low charge. For each event
that leads to a new plan, there is also one for each belief that only the new plan assumes; it fails
where that plan would use it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from contextlib import closing
from dataclasses import dataclass
from functools import cached_property

from companion.acting.contingencies.answers import Answer
from companion.acting.contingencies.changes import (
    BeliefLost,
    Change,
    ChargeAtFloor,
    ChargerLost,
    DrainUp,
    EventTurns,
    SiteLost,
)
from companion.acting.contingencies.hypothetical_flight import HypotheticalFlight
from companion.acting.contingencies.reaction import Reaction
from companion.acting.contingencies.remembered_routes import RememberedRoutes
from companion.acting.contingencies.table import Contingency, ContingencyTable, PlanPosition
from companion.acting.preparation import prepare
from companion.errors import RequestError
from companion.mission.facts import Fact
from companion.mission.model import Mission
from companion.planning.domain import Action
from companion.planning.energy_check import level_after, place_of
from companion.planning.explain import Explanation
from companion.planning.flight_times import route_map
from companion.planning.lasso import ChosenPlan, Energy, Lasso, Problem


@dataclass(frozen=True, slots=True)
class ContingencyQuestion:
    """A change at some positions; for an event, also the changes of the plan for it."""

    change: Change
    positions: tuple[int, ...]


class _Reasons:
    """Caches why problems have no plan; problems that differ only in the place share a reason."""

    def __init__(self, explain: Callable[[Problem], Explanation]) -> None:
        self._explain = explain
        self._known: dict[object, Explanation] = {}

    def __call__(self, problem: Problem) -> Explanation:
        """The reason, computed once."""
        charge = problem.energy and problem.energy.level
        key = problem.withdrawn, problem.automaton_states, problem.clocks_ms, charge
        if key not in self._known:
            self._known[key] = self._explain(problem)
        return self._known[key]


class Contingencies:
    """The contingencies of a mission's first plan.

    >>> from companion import load_mission
    >>> found = Contingencies(load_mission("missions/surveillance.yaml"))
    >>> [position.ahead for position in found.positions]
    ['move(Home, A)', 'move(A, B)', 'move(B, C)', 'move(C, A)']
    >>> print(found.answer(found.questions[0])[0].answer)
    move(here, r2), upload(r2), move(r2, Home), (wait)^w

    Args:
        mission: the mission.

    Raises:
        CompanionError: its flights use no planner, or it has no plan.
    """

    def __init__(self, mission: Mission) -> None:
        if mission.tree is not None:
            raise RequestError(
                "the mission has a tree of its own, which nothing replaces in flight\n"
                "    there is no table of contingencies; remove tree: to have it planned"
            )
        self._mission = mission
        self._prepared = prepare(mission, routes=route_map(mission, RememberedRoutes))
        first = self._prepared.first_plan
        assert first is not None
        if not isinstance(first.outcome, ChosenPlan):
            raise first.outcome
        self._plan: ChosenPlan = first.outcome
        self._energy = first.problem.energy
        self._memory = self._prepared.planner.solver.memory
        self.positions = tuple(_positions(mission, self._plan.lasso, self._energy))

    @cached_property
    def questions(self) -> tuple[ContingencyQuestion, ...]:
        """All questions, in parts that are independent of each other."""
        numbers = tuple(position.number for position in self.positions)
        return tuple(
            ContingencyQuestion(change, asked)
            for change in self._changes()
            for asked in ([(n,) for n in numbers] if isinstance(change, EventTurns) else [numbers])
        )

    def answer(self, question: ContingencyQuestion) -> tuple[Contingency, ...]:
        """The contingencies for a question, including those of plans for an event."""
        change, reasons = question.change, _Reasons(self._prepared.planner.solver.explain_soon)
        found = []
        for number in question.positions:
            answer, plan = self._meet(number, [change], reasons)
            found.append(Contingency(number, change, answer))
            if plan is not None and isinstance(change, EventTurns):
                for later in self._of_plan(plan):
                    answer, _ = self._meet(number, [change, later], reasons)
                    found.append(Contingency(number, later, answer, after=change))
        return tuple(found)

    def table(self, answers: Iterable[tuple[Contingency, ...]]) -> ContingencyTable:
        """The table of the answers to all questions, in the same order."""
        found = [each for several in answers for each in several]
        found.sort(key=lambda each: each.position)
        return ContingencyTable(
            mission=self._mission.name,
            plan=str(self._plan.lasso),
            positions=self.positions,
            contingencies=tuple(found),
        )

    def _changes(self) -> Iterator[Change]:
        mission = self._mission
        for event in mission.events.values():
            holds = event.fact in mission.initially
            if not (holds and event.latch):
                yield EventTurns(event.name, not holds)
        yield from _beliefs(self._plan.lasso, frozenset())
        hidden = (place.name for place in mission.places.values() if not place.found_by)
        yield from map(SiteLost, hidden)
        if self._energy is not None:
            yield DrainUp()
            yield ChargeAtFloor()

    def _of_plan(self, plan: ChosenPlan) -> Iterator[BeliefLost]:
        """The beliefs that the plan for an event assumes, and the first plan does not."""
        return _beliefs(plan.lasso, _assumed(self._plan.lasso))

    def _meet(
        self, number: int, changes: list[Change], reasons: _Reasons
    ) -> tuple[Answer, ChosenPlan | None]:
        """The answer to the last of some successive changes at a position."""
        *before, last = changes
        position = self.positions[number]
        level = None if self._energy is None else self._energy.level
        self._prepared.planner.solver.recall(self._memory)  # as at the beginning of each flight
        with closing(HypotheticalFlight(self._prepared, self._plan, level, reasons)) as flight:
            flight.complete(number, position.level)
            for change in before:
                _, plan = Reaction(flight).to(change)
                assert plan is not None and isinstance(last, BeliefLost)
                flight.adopt(plan)
                actions = (*plan.lasso.prefix, *plan.lasso.loop)
                flight.complete(next(i for i, a in enumerate(actions) if last.belief in a.assumes))
            return Reaction(flight).to(last)


def _positions(mission: Mission, lasso: Lasso, energy: Energy | None) -> Iterator[PlanPosition]:
    facts = mission.initially
    levels = _levels(energy, lasso) if energy is not None else None
    for number, action in enumerate((*lasso.prefix, *lasso.loop)):
        is_in_loop = number >= len(lasso.prefix)
        level = percent = None
        if energy is not None and levels is not None:
            level = levels[number]
            percent = round(energy.percents[max(0, level)], 1)
        yield PlanPosition(number, place_of(facts), action.name, is_in_loop, level, percent)
        facts = action.apply(facts)


def _levels(energy: Energy, lasso: Lasso) -> list[int]:
    """The level before each action; in the loop, of the lap in which it is lowest."""
    level, levels = energy.level, list[int]()
    for action in lasso.prefix:
        levels.append(level)
        level = level_after(energy, level, action)
    if lasso.ends_at_rest:
        return [*levels, *[level] * len(lasso.loop)]
    while True:
        begun, lap = level, list[int]()
        for action in lasso.loop:
            lap.append(level)
            level = level_after(energy, level, action)
        if level >= begun:
            return [*levels, *lap]


def _beliefs(lasso: Lasso, known: frozenset[Fact]) -> Iterator[BeliefLost]:
    """The beliefs that a plan assumes, in the order in which it does."""
    actions: tuple[Action, ...] = (*lasso.prefix, *lasso.loop)
    found: dict[Fact, bool] = {}
    for action in actions:
        for belief in sorted(action.assumes - known):
            found[belief] = found.get(belief, False) or action.charger is not None
    for belief, is_charger in found.items():
        yield ChargerLost(belief) if is_charger else BeliefLost(belief)


def _assumed(lasso: Lasso) -> frozenset[Fact]:
    return frozenset[Fact]().union(*(a.assumes for a in (*lasso.prefix, *lasso.loop)))
