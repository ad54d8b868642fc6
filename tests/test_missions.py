"""Every mission that is shipped can be read, has a plan, and the plan passes the check."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from companion.acting.task_state import TaskState
from companion.errors import NoPlanError
from companion.ltl.parser import parse
from companion.mission.loader import load_mission
from companion.planning.check import fault
from companion.planning.planner import Planner
from companion.run import flight_times, route_map
from sitl.world.scenario import read_scenario

MISSIONS = Path(__file__).parents[1] / "missions"
FILES = sorted(MISSIONS.glob("*.yaml"))
SCENARIOS = [path for path in FILES if path.name.endswith(".sim.yaml")]
OF_ANOTHER_NAME = {"surveillance_all_uploads_fail.sim.yaml": "surveillance.yaml"}
"""Scenarios of a mission that has one of its own name besides."""


def name_of(path: Path) -> str:
    return path.name


def test_the_paper_s_mission_is_among_them() -> None:
    assert MISSIONS / "surveillance.yaml" in FILES
    assert MISSIONS / "surveillance.sim.yaml" in SCENARIOS


@pytest.mark.slow
@pytest.mark.parametrize("path", [p for p in FILES if p not in SCENARIOS], ids=name_of)
def test_a_mission_has_a_plan_that_passes_the_check(path: Path) -> None:
    mission = load_mission(path)
    planner = Planner(mission, flight_times(mission, route_map(mission)))
    problem, histories = TaskState(planner).problem()
    lasso = planner.plan(problem, histories)
    assert fault(problem, lasso, histories) is None


def test_the_zone_of_the_corridor_is_planned_around_until_it_is_clear() -> None:
    """Its line is past_avoidance without the promise that the corridor is cleared one day."""
    mission = load_mission(MISSIONS / "corridor.yaml")
    planner = Planner(mission, flight_times(mission, route_map(mission)))

    def places() -> set[str]:
        lasso = planner.plan(*task.problem())
        return {action.name.rpartition(", ")[2][:-1] for action in lasso.suffix}

    task = TaskState(planner)
    assert places() == {"Shelf", "Bench"}
    task.take(mission.events["corridorClear"], True)
    assert places() == {"Shelf", "Bench", "Corridor"}
    promising = replace(mission, task={"closed": parse("past_avoidance(Corridor, corridorClear)")})
    planner = Planner(promising, planner.flight_time)
    task = TaskState(planner)
    with pytest.raises(NoPlanError, match="corridorClear"):
        places()


@pytest.mark.parametrize("path", SCENARIOS, ids=name_of)
def test_a_scenario_fits_its_mission(path: Path) -> None:
    """The vehicle starts where the mission begins: the companion refuses any other place."""
    name = OF_ANOTHER_NAME.get(path.name, path.name.replace(".sim.yaml", ".yaml"))
    mission = load_mission(path.with_name(name))
    scenario, grid = read_scenario(path)
    home = next(p for name, p in mission.places.items() if f"at({name})" in mission.initially)
    north_m, east_m, _ = home.position
    start_north_m, start_east_m, _ = scenario.start
    assert abs(start_north_m - north_m) <= home.radius_m
    assert abs(start_east_m - east_m) <= home.radius_m
    assert grid is not None
    assert grid.clearance_m((north_m, east_m)) > 0
