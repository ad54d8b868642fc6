"""What `companion figure` draws of a recorded run."""

from __future__ import annotations

import shutil
from contextlib import closing
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from commands import Companion

from companion import load_mission, simulate
from companion.api.figures import backdrop_of_run, trail_of_run
from companion.cli.terminal import Terminal
from companion.flights.cut_off_runs import CutOffRun
from companion.flights.run_folders import RunFolders
from companion.record.backdrop import backdrop_of

MISSIONS = Path(__file__).parents[1] / "missions"


@pytest.fixture(scope="module")
def run_folder(surveillance_run: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return shutil.copytree(surveillance_run, tmp_path_factory.mktemp("figure") / "run")


def test_a_run_has_the_trail_and_the_world_of_its_flight(run_folder: Path) -> None:
    trail, backdrop = trail_of_run(run_folder), backdrop_of_run(run_folder)
    known = backdrop_of(load_mission(MISSIONS / "surveillance.yaml"))
    assert [title for title, _ in trail.parts] == [
        "first plan",
        "replan 1: target found",
        "replan 2: upload(r1) failed: denied",
    ]
    for _, positions in trail.parts:
        assert len(positions) > 20
    assert backdrop.places.keys() == known.places.keys()
    assert backdrop.fence == known.fence
    assert (backdrop.grid.occupied == known.grid.occupied).all()


@pytest.mark.long
def test_a_tree_by_hand_has_a_trail_too(tmp_path: Path) -> None:
    simulate(load_mission(MISSIONS / "by_hand.yaml"), folder=tmp_path, limit_s=20)
    ((title, positions),) = trail_of_run(tmp_path).parts
    assert title == "the tree that was written by hand" and len(positions) > 100


@pytest.mark.long
@pytest.mark.usefixtures("drawn")
def test_a_run_that_was_gone_on_with_is_drawn_from_its_beginning_on(
    companion: Companion, run_folder: Path, tmp_path: Path
) -> None:
    """By a companion that has seen nothing of what was flown before."""
    run = shutil.copytree(run_folder, tmp_path / "runs" / "run")
    (run / "flight.png").unlink()
    mission: Any = load_mission(MISSIONS / "surveillance.yaml")
    journalled: Any = SimpleNamespace(goes_on_s=50.0, positions=3, begun=SimpleNamespace(start_s=0))
    with closing(Terminal()) as terminal:
        cut_off = CutOffRun(run, mission, journalled)
        folders = RunFolders(run.parent, terminal, keeps_journal=True)
        folders.open(mission, cut_off).close()
    whole = tmp_path / "whole.png"
    assert companion("figure", run, "-o", whole).code == 0
    assert (run / "flight.png").read_bytes() == whole.read_bytes()


@pytest.mark.usefixtures("drawn")
@pytest.mark.parametrize("name", ["flight.pdf", pytest.param("flight.svg", marks=pytest.mark.long)])
def test_it_is_drawn_beside_the_run(companion: Companion, run_folder: Path, name: str) -> None:
    ended = companion("figure", run_folder, "--format", name.partition(".")[2])
    assert (ended.code, ended.out) == (0, f"written    {run_folder / name}\n")
    assert (run_folder / name).stat().st_size > 10_000


def test_mistakes_are_answered(companion: Companion, run_folder: Path, tmp_path: Path) -> None:
    assert "not one of .pdf, .svg, .png" in companion("figure", run_folder, "-o", "a.doc").err
    assert "is not a run folder: scene.json cannot be read" in companion("figure", tmp_path).err
    ended = companion("figure", run_folder, "-o", tmp_path / "nowhere" / "a.pdf")
    assert ended.code == 1 and "cannot write" in ended.err
