"""A row as a scenario file is the same world again."""

from __future__ import annotations

import shlex
from dataclasses import replace
from pathlib import Path

from varied import MISSION, SEED, short_kit

from companion.campaigns.cases import simplifiable, write_cases, write_worst
from companion.campaigns.outcomes import FlownRow, RowOutcome
from companion.campaigns.rows import Row, random_row
from companion.flights.simulated_world import varied_world_of


def test_the_file_of_a_row_is_its_world(tmp_path: Path) -> None:
    kit = short_kit()
    rows = [random_row(kit.factors, SEED, index) for index in range(4)]
    flown = [FlownRow(row, RowOutcome.SATISFIED) for row in rows]
    for case in write_worst(kit, MISSION, tmp_path, flown):
        scenario, grid = kit.scenario.world(case.flown.row.values)
        again = varied_world_of(kit.mission, case.file)
        read, read_grid = again.world({})
        assert again.factors == ()
        assert replace(read, map=None, vehicle=scenario.vehicle) == replace(scenario, map=None)
        assert grid is not None and read_grid is not None
        assert (read_grid.occupied == grid.occupied).all()


def test_the_command_of_a_row_can_be_typed_as_it_stands(tmp_path: Path) -> None:
    kit, folder = short_kit(), tmp_path / "my rows"
    row = random_row(kit.factors, SEED, 0)
    (case,) = write_worst(kit, Path("my mission.yaml"), folder, [FlownRow(row, RowOutcome.CRASH)])
    words = shlex.split(case.line)
    assert words[2] == "my mission.yaml" and words[4] == str(folder / "worst" / "0.sim.yaml")


def test_an_event_that_a_failure_does_not_need_is_not_in_its_file(tmp_path: Path) -> None:
    kit = simplifiable(short_kit())
    row = Row(0, 5, {"happens.0": False, "wind.east_mps": 2.5})
    failure = FlownRow(row, RowOutcome.VIOLATED, conjunct="patrol", phase="landing", place="Gate")
    (case,) = write_cases(kit, MISSION, tmp_path, [failure])
    assert case.file.name == "1-violated-patrol.sim.yaml"
    assert case.line == f"companion sim {MISSION} --scenario {case.file} --seed 5 --speed max"
    text = case.file.read_text()
    assert text.startswith("# violated: patrol, while landing, near Gate\n")
    assert "vary" not in text and "RETURN_TO_LAUNCH" not in text
    scenario, _ = varied_world_of(kit.mission, case.file).world({})
    assert [event.text for event in scenario.events] == ["gps: noise_m 0.2"]
    assert scenario.wind[1] == 2.5
