"""`companion new`: each pair of a space and a task is a mission that checks and flies at once."""

from __future__ import annotations

from itertools import product
from pathlib import Path

import pytest
from commands import Companion

from companion import load_mission, simulate
from companion.flight_events.sortie import ReturnedAsAsked, TaskSatisfied
from companion.geometry import GlobalOrigin
from companion.plans.starter import StarterSpace, starter
from companion.plans.starter_tasks import TASKS, TaskName

PAIRS = list(product(StarterSpace, TaskName))
NOW = [
    (StarterSpace.HALL, TaskName.PATROL),
    (StarterSpace.EARTH, TaskName.DELIVERY),
    (StarterSpace.HALL, TaskName.RESPONSE),
]
OF_README = (StarterSpace.FIELD, TaskName.INSPECTION)
"""By tests/test_readme.py. With this one, each space and each task is flown in every run; all pairs
are with the long tests."""


def written(folder: Path, space: StarterSpace, task: TaskName) -> Path:
    made = starter("first", space, task)
    (folder / "first.sim.yaml").write_text(made.world)
    (folder / "first.yaml").write_text(made.mission)
    return folder / "first.yaml"


@pytest.mark.flight
@pytest.mark.parametrize(
    ("space", "task"),
    [pytest.param(*p, marks=[] if p in NOW else [pytest.mark.long]) for p in PAIRS],
)
def test_it_flies_as_it_stands(space: StarterSpace, task: TaskName, tmp_path: Path) -> None:
    run = simulate(load_mission(written(tmp_path, space, task)), seed=3)
    assert (run.exit_code, run.collisions) == (0, 0)
    assert isinstance(run.events[-1].event, TaskSatisfied | ReturnedAsAsked)


@pytest.mark.parametrize(("space", "task"), PAIRS)
def test_its_head_says_what_it_is_and_how_it_is_flown(space: StarterSpace, task: TaskName) -> None:
    made = starter("first", space, task)
    head = made.mission.split("version: 1")[0]
    assert TASKS[task].story[0] in head
    assert "companion sim first.yaml" in head
    assert max(map(len, made.mission.splitlines())) <= 130
    assert ("wgs84" in made.mission) == (space is StarterSpace.EARTH)


def test_each_of_all_spaces_and_tasks_is_flown_in_every_run() -> None:
    assert {task for _, task in (*NOW, OF_README)} == {*TaskName}
    assert {space for space, _ in (*NOW, OF_README)} == {*StarterSpace}


def test_on_the_earth_the_places_lie_about_the_home_that_is_given(tmp_path: Path) -> None:
    home = GlobalOrigin(-33.9, 151.2, 40.0)
    path = tmp_path / "first.yaml"
    path.write_text(starter("first", StarterSpace.EARTH, TaskName.PATROL, home).mission)
    places = load_mission(path).places
    north, east, _ = places["B"].position
    assert (north, east) == pytest.approx((30, 40), abs=0.2)


def test_the_command_writes_two_files_and_the_plan(
    companion: Companion, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.chdir(tmp_path)
    ended = companion("new", "harbour", "--space", "earth", "--task", "inspection")
    assert ended.code == 0, ended.err
    assert "shoot(A)" in ended.out and "companion sim harbour.yaml" in ended.out
    assert companion("check", "harbour.yaml").code == 0
    again = companion("new", "harbour", "--space", "field", "--task", "patrol")
    assert again.code == 2
    assert "harbour.yaml is there already" in again.err
    assert "frame: wgs84" in (tmp_path / "harbour.yaml").read_text()


def test_without_options_and_a_terminal_it_is_a_patrol_of_a_field(
    companion: Companion, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.chdir(tmp_path)
    assert companion("new", "first").code == 0
    assert "patrolling(A, B, C)" in (tmp_path / "first.yaml").read_text()
    assert not load_mission(tmp_path / "first.yaml").walls


@pytest.mark.parametrize("name", ["", "1st", "a b", "../up", "a.yaml"])
def test_a_name_that_is_none_is_refused(companion: Companion, name: str) -> None:
    ended = companion("new", name, "--space", "field", "--task", "patrol")
    assert ended.code == 2
    assert "letters, digits and _" in ended.err


def test_a_home_that_is_none_is_refused(
    companion: Companion, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.chdir(tmp_path)
    ended = companion("new", "first", "--space", "earth", "--task", "patrol", "--home", "north")
    assert ended.code == 2
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("space", ["hall", "field"])
def test_a_home_where_a_mission_is_in_metres_is_refused(
    companion: Companion, monkeypatch: pytest.MonkeyPatch, tmp_path: Path, space: str
) -> None:
    monkeypatch.chdir(tmp_path)
    ended = companion("new", "first", "--space", space, "--task", "patrol", "--home", "47,8")
    assert ended.code == 2
    assert "is of --space earth" in ended.err
    assert not list(tmp_path.iterdir())
