"""The plans of a vehicle on the ground: the first one, and a replacement for it.

The first plan is usually made before the run. If the map has changed since, or the flight has been
given less room, it is searched again on the present map.
"""

from __future__ import annotations

from py_trees.behaviour import Behaviour

from companion.acting.behaviour_tree.hand_built import build_by_hand
from companion.acting.deliberation import Deliberation
from companion.acting.flight import Flight
from companion.acting.preparation import PreparedMission
from companion.acting.replanning.replanner import PlanFailure
from companion.errors import CompanionError, NoPlanError
from companion.flight_events.plans import EngineFailed, WrittenTreeAdopted
from companion.mission.tree_nodes import Tree
from companion.planning.lasso import ChosenPlan


class GroundPlans:
    """The plans with which a flight begins.

    Args:
        prepared: the mission, with its planner and its first plan.
        flight: the flight that begins.
        deliberation: follows the map, and learns what the plan assumes.
    """

    def __init__(
        self, prepared: PreparedMission, flight: Flight, deliberation: Deliberation
    ) -> None:
        self._prepared = prepared
        self._planner = prepared.planner
        self._flight = flight
        self._assumptions = deliberation.assumptions
        self._replanner = deliberation.replanner

    def written(self, tree: Tree) -> Behaviour:
        """The behaviours of a tree that was written by hand."""
        flight, mission = self._flight, self._planner.mission
        root = build_by_hand(flight, tree, self._planner.actions.of_tree(tree))
        flight.report(WrittenTreeAdopted(mission.written_task, mission.priorities))
        return root

    def first(self) -> ChosenPlan | PlanFailure:
        """The first plan, or why there is none."""
        if self._prepared.engine_failure is not None:
            self._flight.report(EngineFailed(self._prepared.engine_failure))
        return self._found()

    def again(self) -> ChosenPlan | PlanFailure | None:
        """The plan on the present map; None if a tree written by hand can still be flown."""
        tree = self._planner.mission.tree
        if tree is None:
            return self._found()
        self._replanner.follow_map()
        try:
            named = self._planner.actions.of_tree(tree).values()
        except CompanionError as error:
            return NoPlanError(str(error))
        flown_to = {action.destination for actions in named for action in actions}
        cut_off = self._replanner.reachability.unreachable & flown_to
        lost = sorted(filter(self._flight.routes.knows, cut_off))
        return NoPlanError(f"the tree flies to {lost[0]}, and no way leads there") if lost else None

    def _found(self) -> ChosenPlan | PlanFailure:
        self._replanner.follow_map()
        self._assumptions.renew()
        return self._prepared.plan(*self._flight.task.problem())
