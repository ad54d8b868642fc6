"""Every mission that is shipped can be read, has a plan, and the plan passes the check."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from companion.errors import NoPlanError
from companion.ltl.parser import parse
from companion.mission.loader import load_mission
from companion.planning.check import fault
from companion.planning.planner import Planner
from sitl.world.scenario import read_scenario

MISSIONS = Path(__file__).parents[1] / "missions"
FILES = sorted(MISSIONS.glob("*.yaml"))
SCENARIOS = [path for path in FILES if path.name.endswith(".sim.yaml")]
OF_ANOTHER_NAME = {
    "surveillance_all_uploads_fail.sim.yaml": "surveillance.yaml",
    "surveillance_rough.sim.yaml": "surveillance.yaml",
}
"""Scenarios of a mission that has one of its own name besides."""


def name_of(path: Path) -> str:
    return path.name


def test_the_paper_s_mission_is_among_them() -> None:
    assert MISSIONS / "surveillance.yaml" in FILES
    assert MISSIONS / "surveillance.sim.yaml" in SCENARIOS


@pytest.mark.slow
@pytest.mark.parametrize("path", [p for p in FILES if p not in SCENARIOS], ids=name_of)
def test_a_mission_has_a_plan_that_passes_the_check(path: Path) -> None:
    planner = Planner(load_mission(path))
    problem, histories = planner.initial_problem()
    assert fault(problem, planner.plan().lasso, histories) is None


def test_the_zone_of_the_corridor_is_planned_around_until_it_is_clear() -> None:
    """Its line is past_avoidance without the promise that the corridor is cleared one day."""
    planner = Planner(load_mission(MISSIONS / "corridor.yaml"))

    def places(*facts: str) -> set[str | None]:
        return {action.destination for action in planner.plan(facts=facts).loop}

    assert places() == {"Shelf", "Bench"}
    assert places("corridorClear") == {"Shelf", "Bench", "Corridor"}
    task = {"closed": parse("past_avoidance(Corridor, corridorClear)")}
    promising = Planner(replace(planner.mission, task=task), planner.actions.flight_time)
    with pytest.raises(NoPlanError, match="corridorClear"):
        promising.plan()


@pytest.mark.slow
@pytest.mark.parametrize("path", SCENARIOS, ids=name_of)
def test_a_scenario_fits_its_mission(path: Path) -> None:
    """The vehicle starts where the mission begins: the companion refuses any other place."""
    name = OF_ANOTHER_NAME.get(path.name, path.name.replace(".sim.yaml", ".yaml"))
    mission = load_mission(path.with_name(name))
    scenario, grid = read_scenario(path)
    north_m, east_m, _ = mission.home.position
    start_north_m, start_east_m, _ = scenario.start
    assert abs(start_north_m - north_m) <= mission.home.inner_m
    assert abs(start_east_m - east_m) <= mission.home.inner_m
    assert grid is not None
    assert grid.clearance_m((north_m, east_m)) > 0
