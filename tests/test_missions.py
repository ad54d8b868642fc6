"""Every mission that is shipped can be read, has a plan, and the plan passes the check."""

from __future__ import annotations

from pathlib import Path

import pytest

from companion.acting.task_state import TaskState
from companion.app import flight_times, route_map
from companion.mission.loader import load_mission
from companion.planning.check import fault
from companion.planning.planner import Planner
from sitl.world.scenario import read_scenario

MISSIONS = Path(__file__).parents[1] / "missions"
FILES = sorted(MISSIONS.glob("*.yaml"))
SCENARIOS = [path for path in FILES if path.name.endswith(".sim.yaml")]


def name_of(path: Path) -> str:
    return path.name


def test_the_paper_s_mission_is_among_them() -> None:
    assert MISSIONS / "surveillance.yaml" in FILES
    assert MISSIONS / "surveillance.sim.yaml" in SCENARIOS


@pytest.mark.parametrize("path", [p for p in FILES if p not in SCENARIOS], ids=name_of)
def test_a_mission_has_a_plan_that_passes_the_check(path: Path) -> None:
    mission = load_mission(path)
    planner = Planner(mission, flight_times(mission, route_map(mission)))
    problem, histories = TaskState(planner).problem()
    lasso = planner.plan(problem, histories)
    assert fault(problem, lasso, histories) is None


@pytest.mark.parametrize("path", SCENARIOS, ids=name_of)
def test_a_scenario_fits_its_mission(path: Path) -> None:
    """The vehicle starts where the mission begins: the companion refuses any other place."""
    mission = load_mission(path.with_name(path.name.replace(".sim.yaml", ".yaml")))
    scenario, grid = read_scenario(path)
    home = next(p for name, p in mission.places.items() if f"at({name})" in mission.initially)
    north_m, east_m, _ = home.position
    start_north_m, start_east_m, _ = scenario.start
    assert abs(start_north_m - north_m) <= home.radius_m
    assert abs(start_east_m - east_m) <= home.radius_m
    assert grid is not None
    assert grid.clearance_m((north_m, east_m)) > 0
