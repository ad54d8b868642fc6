"""Plans again in flight, in parts that each fit into a tick; the vehicle holds meanwhile.

1. A plan waits until the routes on the map are known, but not for ever: a map may go on changing.
2. A search in flight is small. It is for the lines of the task that can be kept, which are chosen
   first; if it finds no plan, the reason is searched for. Both are done in parts, some in each
   tick; a change meanwhile, of more than costs, begins anew.
3. An engine from outside is waited for; where it fails, the built-in search is asked.
4. Plans for failed skills between which no skill is completed lead nowhere; after some in a row all
   optional lines are dropped, and without any it is given up. A plan for an event is none of them:
   the one before was not wrong.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass

from companion.acting.flight import Flight
from companion.acting.replanning.assumptions import FLAPPING_S, Assumptions
from companion.acting.replanning.engine_search import EngineSearch
from companion.acting.replanning.optional_lines import OptionalLines
from companion.acting.replanning.reachability import Reachability
from companion.acting.replanning.search_in_parts import SearchInParts, what_decides
from companion.errors import NoPlanError, SearchLimit
from companion.flight_events.facts import PlacesCutOff
from companion.flight_events.plans import EngineFailed
from companion.planning.engine_port import Engine, EngineFailure
from companion.planning.explain import Explanation, NoPlan
from companion.planning.lasso import ChosenPlan, Lasso, Letter, Problem
from companion.planning.optional_lines import without_lines
from companion.planning.planner import Planner

COMPARED = 1000
"""Actions of two plans after which they are taken for the same."""
MAX_IDLE_REPLANS = 5
"""Replans, other than for events, without a completed skill between them: then it is given up."""
MAP_SETTLES_S = 5.0
"""How long a replan waits for a map that goes on changing while the vehicle holds."""

PlanFailure = NoPlanError | SearchLimit
"""There is no plan, or none was found within the limits of the search: a value here, which the
sortie hands out as its failure."""


@dataclass(frozen=True, slots=True)
class DueReplan:
    """A plan that is due in flight.

    Attributes:
        reason: why, in words for people.
        since_s: from when on.
    """

    reason: str
    since_s: float


class Replanner:
    """Makes one plan after the other.

    Attributes:
        reachability: the moves that the map leaves.
        lines: which of the task plans keep.

    Args:
        planner: the mission's planner.
        flight: from where plans are made.
        assumptions: learns of the beliefs that the map gives back.
        engine: who plans; None for the built-in search, which is asked where an engine fails, and
            whether the present plan is still the best one.
    """

    def __init__(
        self,
        planner: Planner,
        flight: Flight,
        assumptions: Assumptions,
        engine: Engine | None = None,
    ) -> None:
        self.reachability = Reachability(planner, flight)
        self._planner = planner
        self._flight = flight
        self._assumptions = assumptions
        self._engine = EngineSearch(engine) if engine is not None else None
        self.lines = OptionalLines(planner, flight)
        self._explanation: SearchInParts[Explanation] | None = None
        self._idle_replans = 0
        self._completed = 0
        self._looked_at: tuple[object, ...] = ()
        self._looked_s = 0.0

    @property
    def is_explaining(self) -> bool:
        """Whether there is no plan, and the reason is being searched for."""
        return self._explanation is not None

    def begin(self, reason: str) -> DueReplan:
        """Another plan is due from now on."""
        self.abandon()
        if self._assumptions.wrong:  # the world has changed: the plan before was none that failed
            self._assumptions.note_replan()
        else:
            self._count_idle()
        return DueReplan(reason, self._flight.now_s)

    def abandon(self) -> None:
        """Nobody waits for a plan any more."""
        self._explanation = None
        self.lines.abandon()
        if self._engine is not None:
            self._engine.abandon()

    def forgive(self) -> None:
        """Plans that led nowhere do not count any more: the operator wants to go on."""
        self._idle_replans = 0

    def step(self, due: DueReplan) -> ChosenPlan | PlanFailure | None:
        """The part of a tick; the plan, or why there is none, when that is known."""
        reachability, flight = self.reachability, self._flight
        reachability.search()
        if not reachability.is_known and flight.now_s < due.since_s + MAP_SETTLES_S:
            return None
        self.follow_map()
        problem, histories = flight.task.problem()
        self._looked_at, self._looked_s = what_decides(problem), flight.now_s
        if self.lines.is_outdated_by(problem):
            self.abandon()
            self._count_idle()  # what flaps must not be asked about for ever
        self._assumptions.forget_restored_beliefs()
        if self._planner.mission.tree is not None:
            return NoPlanError("no plan: the mission has a tree of its own")
        is_in_vain = self._idle_replans > MAX_IDLE_REPLANS
        if is_in_vain and flight.task.dropped == flight.task.optional:
            return NoPlanError(f"no plan: {MAX_IDLE_REPLANS} plans in a row led nowhere")
        dropped = self.lines.all_in_vain if is_in_vain else self.lines.choose(problem)
        if dropped is None:
            return None
        kept = without_lines([each.line for each in dropped], problem, histories)
        found = self._plan(*kept)
        return ChosenPlan(found, dropped) if isinstance(found, Lasso) else found

    def _plan(
        self, problem: Problem, histories: Sequence[Sequence[Letter]]
    ) -> Lasso | PlanFailure | None:
        """The part of a tick of planning for the lines that are kept."""
        if self._explanation is not None:
            return self._explain(self._explanation)
        if self._engine is not None:
            match self._engine.step(problem, histories, self._flight.now_s):
                case EngineFailure(reason):
                    self._flight.report(EngineFailed(reason))
                case answer:
                    return answer
        found = self._search(problem, histories)
        if found is not None:
            return found
        self._explanation = SearchInParts(problem, self._planner.reasons(problem))
        return self._explain(self._explanation)

    def _explain(self, search: SearchInParts[Explanation]) -> NoPlan | None:
        """The part of a tick of finding out why there is no plan."""
        explanation = search.step()
        return NoPlan(explanation) if explanation is not None else None

    def looks_again(self) -> bool:
        """Whether something has changed since the last look for a plan, a second ago or more."""
        self.reachability.search()
        is_early = self._flight.now_s - self._looked_s < FLAPPING_S
        if is_early or not self.reachability.is_known:
            return False
        self.follow_map()
        return what_decides(self._flight.task.problem()[0]) != self._looked_at

    def follow_map(self) -> PlacesCutOff | None:
        """Takes the map over into moves and beliefs; returns what was given up, if anything."""
        change = self.reachability.follow()
        if change.connected is not None:
            self._assumptions.note_restored_beliefs()
        return change.cut_off

    def plan_now(self) -> Lasso | None:
        """The plan that would be made now for the lines that are kept; None if none is found."""
        return self._plan_without(self._flight.task.dropped)

    @property
    def is_possible(self) -> bool:
        """Whether there is a plan for the lines of the task that are never dropped."""
        return self._plan_without(self._flight.task.optional) is not None

    def _plan_without(self, lines: Collection[str]) -> Lasso | None:
        found = self._search(*without_lines(lines, *self._flight.task.problem()))
        return found if isinstance(found, Lasso) else None

    def search_confirms(self, lasso: Lasso) -> bool:
        """Plans now, as from the place left last: whether that is the rest of the present plan."""
        new = self.plan_now() if self._flight.task.running is not None else None
        return new is not None and self.is_rest_of(lasso, new)

    def is_rest_of(self, lasso: Lasso, new: Lasso) -> bool:
        """Whether a new plan is what is left of the present one."""
        return new.names(COMPARED) == lasso.names(COMPARED, self._flight.progress.completed)

    def _search(
        self, problem: Problem, histories: Sequence[Sequence[Letter]]
    ) -> Lasso | SearchLimit | None:
        """The first plan that is found, the limit at which it was given up, or None for no plan."""
        try:
            return self._planner.replan(problem, histories)
        except SearchLimit as limit:
            return limit

    def _count_idle(self) -> None:
        """Counts replans between which the task's word has not grown."""
        completed = self._flight.task.completed
        self._idle_replans = 0 if completed > self._completed else self._idle_replans + 1
        self._completed = completed
