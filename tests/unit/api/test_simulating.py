"""Flights without files: what is flown where, what comes back, what it leaves on disk if asked."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from there import THERE

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
from companion.flight_events.event import Stamped
from companion.flight_events.reading import read_line
from companion.flight_events.skills import PlaceReached
from companion.flight_events.sortie import TaskSatisfied
from companion.mission.otherwise import Otherwise


@pytest.fixture(scope="module")
def mission() -> Mission:
    return load_mission(THERE)


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


@pytest.mark.parametrize("loss", [pytest.param(0.0, marks=pytest.mark.long), 0.2])
def test_a_flight_is_the_same_with_a_record(mission: Mission, loss: float, tmp_path: Path) -> None:
    """Both sides send as many datagrams: a link that loses takes the same ones."""
    world = {"version": 1, "happens": [{"at_s": 0.5, "link": {"port": "companion", "loss": loss}}]}
    without = simulate(mission, world, seed=3)
    recorded = simulate(mission, world, seed=3, folder=tmp_path / "run")
    assert np.array_equal(recorded.trajectory.positions, without.trajectory.positions)
    assert recorded.events == without.events


def test_a_failure_is_a_value(mission: Mission) -> None:
    hopeless = load_mission({**THERE, "goal": "at(A) & at(Home)", "otherwise": "land"})
    assert hopeless.otherwise is Otherwise.LAND
    run = simulate(hopeless)
    assert run.exit_code == 3
    assert isinstance(run.failure, NoPlanError)


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


@pytest.mark.long
def test_an_audit_of_the_result_is_that_of_its_folder(mission: Mission, tmp_path: Path) -> None:
    run: FlightResult = simulate(mission, folder=tmp_path)
    assert audit(run) == audit(tmp_path) == audit(str(tmp_path))
    assert [finding.outcome.value for finding in audit(run).findings] == ["fulfilled"]


def test_what_has_no_plan_cannot_be_audited() -> None:
    run = simulate(load_mission({**THERE, "goal": "at(A) & at(Home)"}))
    with pytest.raises(MissionError, match="no plan was made"):
        audit(run)
