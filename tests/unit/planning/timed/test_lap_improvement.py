"""Laps over many sites with bounds in time, which no search through all of them finds soon."""

from __future__ import annotations

from benches.time_bounds import bounded
from benches.worlds import straight

from companion.planning.effort import IN_FLIGHT
from companion.planning.planner import Planner
from companion.planning.time_check import time_fault


def test_a_lap_over_many_sites_is_found_in_flight() -> None:
    """The order of the tour, with visits put in where they fall due, leads to none."""
    mission = bounded(14, 0.6, 1.1, 1)
    planner = Planner(mission, straight(mission))
    problem, histories = planner.initial_problem()
    lasso = planner.solver.replan(problem, histories)
    assert lasso is not None and time_fault(problem, lasso) is None
    visits = [action.arguments[-1] for action in lasso.loop if action.skill == "move"]
    assert len(visits) > len(set(visits))
    assert planner.solver.is_solvable(problem, IN_FLIGHT)
    assert planner.solver.replan(problem, histories) == lasso
