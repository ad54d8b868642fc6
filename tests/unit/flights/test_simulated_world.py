"""The world of a simulated flight, and what a collision in it means for the flight's result."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from there import THERE

from companion.errors import Aborted, CompanionError, MissionError, NoPlanError
from companion.flights.simulated_world import scenario_beside, verdict, world_in_words, world_of
from companion.mission.loader import load_mission
from companion.mission.model import Mission

HOP = Path(__file__).parents[2] / "data" / "hop.yaml"


@pytest.fixture(scope="module")
def mission() -> Mission:
    return load_mission(THERE)


def test_by_default_the_world_is_that_of_the_mission(mission: Mission) -> None:
    scenario, grid = world_of(mission)
    assert grid is mission.grid
    assert scenario.wind == (0.0, 0.0, 0.0)


def test_a_scenario_beside_the_mission_is_taken(surveillance: Mission) -> None:
    scenario, grid = world_of(surveillance)
    assert scenario.wind != (0.0, 0.0, 0.0)
    assert scenario.map is not None
    assert grid is not surveillance.grid


@pytest.mark.parametrize(
    ("mission_ending", "world_endings", "taken"),
    [
        (".yaml", [".sim.yaml"], ".sim.yaml"),
        (".yml", [".sim.yml", ".sim.yaml"], ".sim.yml"),
        (".yml", [".sim.yaml"], ".sim.yaml"),
        (".yaml", [".sim.yml"], ".sim.yml"),
    ],
)
def test_a_world_may_end_with_yml(
    tmp_path: Path, mission_ending: str, world_endings: list[str], taken: str
) -> None:
    path = tmp_path / f"hop{mission_ending}"
    path.write_text(HOP.read_text(encoding="utf-8"), encoding="utf-8")
    for ending in world_endings:
        (tmp_path / f"hop{ending}").write_text(TEXT, encoding="utf-8")
    mission = load_mission(path)
    beside = scenario_beside(mission)
    assert beside == tmp_path / f"hop{taken}"
    assert world_in_words(mission, beside) == str(beside)


def test_the_world_of_a_mission_without_one_is_told(tmp_path: Path, surveillance: Mission) -> None:
    path = tmp_path / "hop.yaml"
    path.write_text(HOP.read_text(encoding="utf-8"), encoding="utf-8")
    without = "without wind (there is no hop.sim.yaml beside it)"
    assert world_in_words(load_mission(path), None) == f"an open field, {without}"
    assert world_in_words(surveillance, None).startswith("the mission's own map, without wind")


TEXT = "version: 1\nwind: {east_mps: 2}\n"
DATA = {"version": 1, "wind": {"east_mps": 2}}


@pytest.mark.parametrize("given", [TEXT, DATA], ids=["text", "data"])
def test_a_scenario_of_a_few_words_is_about_the_mission(mission: Mission, given: Any) -> None:
    scenario, grid = world_of(mission, given)
    assert scenario.wind == pytest.approx((0.0, 2.0, 0.0))
    assert grid is mission.grid
    assert scenario.lidar is not None


def test_obstacles_stand_on_the_missions_map(mission: Mission) -> None:
    crate = {"name": "crate", "box": {"east_m": [3, 4], "north_m": [3, 4]}}
    scenario, _ = world_of(mission, {"version": 1, "obstacles": [crate]})
    assert [obstacle.name for obstacle in scenario.obstacles] == ["crate"]


def test_the_vehicle_does_not_start_in_a_wall_of_the_mission(mission: Mission) -> None:
    with pytest.raises(MissionError, match=r"^start: the start lies in a wall"):
        world_of(mission, {"version": 1, "start": {"east_m": 4.5, "north_m": 0}})


def test_a_scenario_in_a_file_says_all(mission: Mission, tmp_path: Path) -> None:
    path = tmp_path / "empty.sim.yaml"
    path.write_text("version: 1\n", encoding="utf-8")
    for given in (path, str(path)):
        assert world_of(mission, given)[1] is None


@pytest.mark.parametrize(
    "failure", [None, NoPlanError("no plan"), Aborted("a failsafe has control")]
)
def test_a_collision_is_told_with_how_the_flight_had_ended(failure: CompanionError | None) -> None:
    """Of a vehicle that a failsafe had flown into a wall nothing but the failsafe was told."""
    assert verdict(failure, is_damaged=False) is failure
    told = verdict(failure, is_damaged=True)
    assert told is not None and told.exit_code == 5 and "has hit" in str(told)
    assert ("had ended: a failsafe" in str(told)) is isinstance(failure, Aborted)
