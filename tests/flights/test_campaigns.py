"""One campaign has one table, byte for byte, however its rows were flown."""

from __future__ import annotations

import gc
import multiprocessing
import os
import signal
from contextlib import closing
from dataclasses import replace
from pathlib import Path

import pytest
from offered import TEMPLATE, install_template, installed_in
from shipped import MISSIONS
from varied import DEADLY, RUNS, ThisProcess, fly_but_die, short_kit, table_by, tell_process

from companion.app import Companion
from companion.campaigns import measuring, worker
from companion.campaigns.kit import Kit
from companion.campaigns.outcomes import FlownRow, RowOutcome
from companion.campaigns.processes import LocalProcesses, accepted
from companion.campaigns.row_file import NAME
from companion.campaigns.rows import Row
from companion.campaigns.worker import WorkerRefused, fly_row
from companion.errors import CompanionError
from companion.flights.simulated_world import varied_world_of, world_of
from companion.mission.loader import load_mission
from sitl.simulation import Simulation
from sitl.world import varied_scenario


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("campaign")


@pytest.fixture(scope="module")
def table(folder: Path) -> bytes:
    return table_by(ThisProcess(short_kit()), folder)


def test_the_rows_are_flown(table: bytes, folder: Path) -> None:
    assert table.count(b",satisfied,") + table.count(b",invalid,") == RUNS
    assert str(folder).encode() not in table


@pytest.mark.long
def test_two_processes_one_of_which_is_killed(table: bytes, tmp_path: Path) -> None:
    engine = LocalProcesses(short_kit().packed, 2)
    killed: list[int] = []

    def kill(flown: FlownRow) -> None:
        if not killed and (pids := engine.pids):
            killed.append(pids[0])
            os.kill(pids[0], signal.SIGKILL)

    assert table_by(engine, tmp_path, kill) == table
    assert killed


@pytest.mark.long
def test_ctrl_c_ends_no_process_that_is_still_starting() -> None:
    before = {process.pid for process in multiprocessing.active_children()}
    with closing(LocalProcesses(short_kit().packed, 1, tell_process)) as engine:
        (started,) = {process.pid for process in multiprocessing.active_children()} - before
        assert started is not None
        os.kill(started, signal.SIGINT)
        (flown,) = engine.fly([Row(0, 1)])
    assert flown.reason == str(started)


def test_a_campaign_that_was_cut_off_in_a_line_goes_on(
    table: bytes, folder: Path, tmp_path: Path
) -> None:
    header, *lines = (folder / NAME).read_bytes().splitlines(keepends=True)
    torn = lines[2][: len(lines[2]) // 2]
    (tmp_path / NAME).write_bytes(header + lines[3] + lines[0] + torn)
    engine = ThisProcess(short_kit())
    assert table_by(engine, tmp_path) == table
    assert engine.flown == [1, 2]


def test_a_worker_of_another_kind_is_refused() -> None:
    kit = short_kit()
    other = replace(kit, environment={**kit.environment, "fingerprint": "another"})
    answer = fly_row(other.packed, Row(0, 0))
    assert isinstance(answer, WorkerRefused) and answer.line.startswith("fingerprint: ")
    with pytest.raises(CompanionError, match="would fly other rows"):
        accepted(answer)


def test_a_setpoint_that_counts_from_the_origin_before_is_not_far_away() -> None:
    """The autopilot is told another origin, 2.6 km away, while one is on its way."""
    mission = load_mission(MISSIONS / "field.yaml")
    scenario = (MISSIONS / "field.sim.yaml").read_text(encoding="utf-8")
    assert "at_s: 40" in scenario
    world = world_of(mission, scenario.replace("at_s: 40", "at_s: 20.03"))
    flown = measuring.fly(mission, world, Row(0, 0), 22.0)
    assert flown.margins.carrot_m is not None and flown.margins.carrot_m > 0.0


def test_of_a_flight_that_was_flown_nothing_stays() -> None:
    """Whatever other tests have left there."""
    before = [id(each) for each in gc.get_objects() if type(each) in (Companion, Simulation)]
    fly_row(short_kit().packed, Row(0, 1, {}))
    after = [each for each in gc.get_objects() if type(each) in (Companion, Simulation)]
    assert all(id(each) in before for each in after)


def test_what_raises_is_the_outcome_of_its_row(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(worker, "fly", lambda *about: 1 / 0)
    flown = fly_row(short_kit().packed, Row(0, 0))
    assert flown == FlownRow(
        Row(0, 0), RowOutcome.ERROR, reason="ZeroDivisionError: division by zero"
    )


def test_so_is_what_raises_while_its_world_is_made(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(varied_scenario, "with_values", lambda *about: 1 / 0)
    flown = fly_row(short_kit().packed, Row(0, 0))
    assert isinstance(flown, FlownRow) and flown.outcome is RowOutcome.ERROR


@pytest.mark.long
def test_one_process_and_four(table: bytes, tmp_path: Path) -> None:
    for jobs in (1, 4):
        assert table_by(LocalProcesses(short_kit().packed, jobs), tmp_path / str(jobs)) == table


@pytest.mark.long
def test_skills_in_python_are_called_in_processes_of_the_row(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    install_template(tmp_path)
    installed_in(tmp_path / "site", monkeypatch)
    mission = load_mission(TEMPLATE / "weighing.yaml")
    scenario = {"version": 1, "vary": {"wind.east_mps": [-3, 3]}}
    kit = Kit.of(mission, varied_world_of(mission, scenario), 120.0)
    here = table_by(ThisProcess(kit), tmp_path / "here", kit=kit)
    there = table_by(LocalProcesses(kit.packed, 2), tmp_path / "there", kit=kit)
    assert here == there and here.count(b",satisfied,") == RUNS


@pytest.mark.long
def test_a_row_that_kills_its_process_three_times_has_died() -> None:
    """The other row of the same process is flown."""
    engine = LocalProcesses(short_kit().packed, 1, fly_but_die)
    try:
        flown = {each.row.index: each.outcome for each in engine.fly([Row(0, DEADLY), Row(1, 1)])}
    finally:
        engine.close()
    assert flown == {0: RowOutcome.DIED, 1: RowOutcome.SATISFIED}
