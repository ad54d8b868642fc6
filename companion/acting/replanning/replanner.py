"""Plans again in flight, in parts that each fit into a tick; the vehicle holds meanwhile.

1. A plan waits until the routes on the map are known, but not for ever: a map may go on changing.
2. A search in flight is small. If it finds no plan, the reason is searched for, a part in each
   tick; a change meanwhile, of more than costs, begins anew.
3. Plans between which no skill is completed lead nowhere; after some in a row it is given up.
"""

from __future__ import annotations

from companion.acting.flight import Flight
from companion.acting.replanning.assumptions import Assumptions
from companion.acting.replanning.explanation import ExplanationSearch
from companion.acting.replanning.reachability import Reachability
from companion.errors import NoPlanError, SearchLimit
from companion.planning.lasso import Lasso
from companion.planning.planner import Planner

COMPARED = 1000
"""Actions of two plans after which they are taken for the same."""
MAX_IDLE_REPLANS = 5
"""Replans without a completed skill between them after which it is given up."""
PATIENCE_S = 5.0
"""How long a replan waits for a map that goes on changing while the vehicle holds."""

PlanFailure = NoPlanError | SearchLimit
"""There is no plan, or none was found within the limits of the search."""


class Replanner:
    """Makes one plan after the other.

    Attributes:
        reachability: the moves that the map leaves.
        reason: why the last plan was, or is, due.

    Args:
        planner: the mission's planner.
        flight: from where plans are made.
        assumptions: learns of the beliefs that the map gives back.
    """

    def __init__(self, planner: Planner, flight: Flight, assumptions: Assumptions) -> None:
        self.reachability = Reachability(planner, flight)
        self.reason = ""
        self._planner = planner
        self._flight = flight
        self._assumptions = assumptions
        self._due_s = 0.0
        self._explanation: ExplanationSearch | None = None
        self._idle_replans = 0
        self._positions = 0

    @property
    def is_explaining(self) -> bool:
        """Whether there is no plan, and the reason is being searched for."""
        return self._explanation is not None

    def begin(self, reason: str) -> None:
        """A plan is due from now on."""
        self.reason, self._due_s = reason, self._flight.now_s
        self._explanation = None
        self._count_idle()

    def forgive(self) -> None:
        """Plans that led nowhere do not count any more: the operator wants to go on."""
        self._idle_replans = 0

    def step(self) -> Lasso | PlanFailure | None:
        """The part of a tick; the plan, or why there is none, when that is known."""
        reachability, flight = self.reachability, self._flight
        reachability.search()
        if not reachability.is_known and flight.now_s < self._due_s + PATIENCE_S:
            return None
        self.follow_map()
        problem, histories = flight.task.problem()
        if self._explanation is not None:
            if self._explanation.is_about(problem):
                return self._explanation.step()
            self._count_idle()  # what flaps must not be asked about for ever
        self._assumptions.forget_restored_beliefs()
        if self._planner.mission.tree is not None:
            return NoPlanError("no plan: the mission has a tree of its own")
        if self._idle_replans > MAX_IDLE_REPLANS:
            return NoPlanError(f"no plan: {MAX_IDLE_REPLANS} plans in a row led nowhere")
        try:
            lasso = self._planner.replan(problem, histories)
        except (NoPlanError, SearchLimit) as error:
            return error
        if lasso is not None:
            return lasso
        self._explanation = ExplanationSearch(self._planner, problem)
        return self._explanation.step()

    def follow_map(self) -> str:
        """Takes the map over into moves and beliefs; returns what was given up, in words."""
        change = self.reachability.follow()
        if change.held:
            self._assumptions.note_restored_beliefs()
        return change.lost_in_words

    def plan_now(self) -> Lasso | None:
        """The plan that would be made now; None if none is found."""
        try:
            return self._planner.replan(*self._flight.task.problem())
        except (NoPlanError, SearchLimit):
            return None

    def is_still_best(self, lasso: Lasso) -> bool:
        """Whether a plan made now, as from the place left last, is the rest of the present one."""
        new = self.plan_now() if self._flight.task.running is not None else None
        return new is not None and self.is_rest_of(lasso, new)

    def is_rest_of(self, lasso: Lasso, new: Lasso) -> bool:
        """Whether a new plan is what is left of the present one."""
        return new.names(COMPARED) == lasso.names(COMPARED, self._flight.progress.completed)

    def _count_idle(self) -> None:
        """Counts replans between which the task's word has not grown."""
        positions = self._flight.task.positions
        self._idle_replans = 0 if positions > self._positions else self._idle_replans + 1
        self._positions = positions
