"""Flights without files: what is flown where, what comes back, what it leaves on disk if asked."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from companion import (
    FlightResult,
    Mission,
    MissionError,
    NoPlanError,
    SimulationResult,
    audit,
    load_mission,
    simulate,
)
from companion.errors import Aborted, CompanionError
from companion.flight_events.event import Stamped
from companion.flight_events.reading import read_line
from companion.flight_events.skills import PlaceReached
from companion.flight_events.sortie import TaskSatisfied
from companion.flights.simulated_world import scenario_beside, verdict, world_in_words, world_of
from companion.mission.otherwise import Otherwise

MISSIONS = Path(__file__).parents[3] / "missions"
MISSION: dict[str, Any] = {
    "version": 1,
    "name": "there",
    "map": {
        "east_m": [-2, 8],
        "north_m": [-2, 8],
        "walls": [{"east_m": [4, 5], "north_m": [-2, 1]}],
    },
    "limits": {"speed_mps": 3, "up_m": [0.5, 4], "fence": [[-2, -2], [8, -2], [8, 8], [-2, 8]]},
    "places": {
        "Home": {"east_m": 0, "north_m": 0, "up_m": 2},
        "A": {"east_m": 6, "north_m": 5, "up_m": 2},
    },
    "sets": {"Place": ["Home", "A"]},
    "skills": {
        "move": {
            "parameters": {"from": "Place", "to": "Place"},
            "precondition": "at(from)",
            "assumes": "ok(to)",
            "effect": "at(to) & !at(from)",
            "execute": "fly(to)",
        }
    },
    "initially": ["at(Home)"],
    "goal": "at(A)",
}

HOP = Path(__file__).parents[2] / "data" / "hop.yaml"


@pytest.fixture(scope="module")
def mission() -> Mission:
    return load_mission(MISSION)


@pytest.fixture(scope="module")
def flown(mission: Mission) -> SimulationResult:
    return simulate(mission, seed=3)


def test_a_mission_without_files_is_flown_to_its_end(flown: SimulationResult) -> None:
    assert (flown.exit_code, flown.failure, flown.folder) == (0, None, None)
    events = [stamped.event for stamped in flown.events]
    assert [event.place for event in events if isinstance(event, PlaceReached)] == ["A"]
    assert events[-1] == TaskSatisfied()
    assert flown.collisions == 0


def test_the_trajectory_is_where_the_vehicle_truly_was(flown: SimulationResult) -> None:
    path = flown.trajectory
    assert np.all(np.diff(path.times_s) > 0)
    assert path.times_s[-1] == pytest.approx(flown.events[-1].time_s, abs=0.1)
    start, end = path.positions[0], path.positions[-1]
    assert start == pytest.approx([0.0, 0.0, 0.0], abs=0.1)
    assert end[:2] == pytest.approx([5.0, 6.0], abs=0.5)
    assert path.up_m.max() == pytest.approx(2.3, abs=0.4)
    assert (path.north_m[-1], path.east_m[-1]) == pytest.approx(tuple(end[:2]))


def test_equal_arguments_give_equal_flights(mission: Mission) -> None:
    gusts = {"version": 1, "wind": {"turbulence_mps": 0.3}}
    first, again, other = (simulate(mission, gusts, seed=seed) for seed in (3, 3, 4))
    assert again.events == first.events
    assert np.array_equal(again.trajectory.positions, first.trajectory.positions)
    assert not np.array_equal(other.trajectory.positions, first.trajectory.positions)


@pytest.mark.parametrize("loss", [0.0, 0.2])
def test_a_flight_is_the_same_with_a_record(mission: Mission, loss: float, tmp_path: Path) -> None:
    """Both sides send as many datagrams: a link that loses takes the same ones."""
    world = {"version": 1, "happens": [{"at_s": 0.5, "link": {"port": "companion", "loss": loss}}]}
    without = simulate(mission, world, seed=3)
    recorded = simulate(mission, world, seed=3, folder=tmp_path / "run")
    assert np.array_equal(recorded.trajectory.positions, without.trajectory.positions)
    assert recorded.events == without.events


def test_a_failure_is_a_value(mission: Mission) -> None:
    hopeless = load_mission({**MISSION, "goal": "at(A) & at(Home)", "otherwise": "land"})
    assert hopeless.otherwise is Otherwise.LAND
    run = simulate(hopeless)
    assert run.exit_code == 3
    assert isinstance(run.failure, NoPlanError)


# -- the world -------------------------------------------------------------------------------------


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
    ("given", "where"),
    [({"version": 1, "wnd": {}}, "wnd: "), ("version: 1\nwnd: {}\n", "<scenario>:2:1: ")],
)
def test_a_mistake_is_told_with_its_place(mission: Mission, given: Any, where: str) -> None:
    with pytest.raises(MissionError, match=f"^{where}unknown key 'wnd'"):
        simulate(mission, given)


# -- what it leaves --------------------------------------------------------------------------------


def test_events_are_told_when_they_happen_and_recorded_if_asked(
    mission: Mission, flown: SimulationResult, tmp_path: Path
) -> None:
    told: list[Stamped] = []
    run = simulate(mission, seed=3, folder=tmp_path / "run", on_event=told.append)
    assert run.folder == tmp_path / "run"
    assert {"events.jsonl", "flight.png", "flight.tlog", "mission.yaml"} <= {
        path.name for path in run.folder.iterdir()
    }
    lines = (run.folder / "events.jsonl").read_text(encoding="utf-8").splitlines()
    assert tuple(read_line(line) for line in lines) == run.events
    assert told == [stamped for stamped in run.events if stamped.event.is_told]
    assert run.events == flown.events


def test_the_mission_that_is_left_can_be_loaded_again(mission: Mission, tmp_path: Path) -> None:
    path = tmp_path / "mission.yaml"
    path.write_text(mission.text, encoding="utf-8")
    again = load_mission(path)
    assert again.task == mission.task
    assert np.array_equal(again.grid.occupied, mission.grid.occupied)


def test_an_audit_of_the_result_is_that_of_its_folder(mission: Mission, tmp_path: Path) -> None:
    run: FlightResult = simulate(mission, folder=tmp_path)
    assert audit(run) == audit(tmp_path) == audit(str(tmp_path))
    assert [finding.outcome.value for finding in audit(run).findings] == ["fulfilled"]


def test_what_has_no_plan_cannot_be_audited() -> None:
    run = simulate(load_mission({**MISSION, "goal": "at(A) & at(Home)"}))
    with pytest.raises(MissionError, match="no plan was made"):
        audit(run)


@pytest.mark.parametrize(
    "failure", [None, NoPlanError("no plan"), Aborted("a failsafe has control")]
)
def test_a_collision_is_told_with_how_the_flight_had_ended(failure: CompanionError | None) -> None:
    """Of a vehicle that a failsafe had flown into a wall nothing but the failsafe was told."""
    assert verdict(failure, is_damaged=False) is failure
    told = verdict(failure, is_damaged=True)
    assert told is not None and told.exit_code == 5 and "has hit" in str(told)
    assert ("had ended: a failsafe" in str(told)) is isinstance(failure, Aborted)
