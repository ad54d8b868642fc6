"""Three clocks beside each other, and the mark by which the vehicle's own log is found."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from lockstep import Lockstep
from synthetic import mission

from companion.flights.simulated_world import world_of
from companion.ground.texts import ERROR, StatusTextQueue
from companion.mavlink.statustext import CHUNK_BYTES
from companion.record.clocks import ClockFile, read_clocks
from companion.record.run_folder import RunFolder
from companion.vehicle.boot_clock import ClockOffset
from companion.vehicle.run_clocks import ClockReading

ROOT = Path(__file__).parents[3]
ARMED = ClockReading("armed", 12.5, 5012.5, ClockOffset(-3.25, 0.004))


def samples(folder: Path) -> list[dict[str, Any]]:
    data = json.loads((folder / "clocks.json").read_text(encoding="utf-8"))
    assert data["version"] == 1
    return list(data["samples"])


def write(path: Path, text: str) -> None:
    path.write_text(text, encoding="utf-8")


def test_a_sample_has_three_clocks(tmp_path: Path) -> None:
    file = ClockFile(tmp_path, False, write, lambda clock_s: 1.7e9 + clock_s)
    file.add(ARMED)
    assert samples(tmp_path) == [
        {
            "at": "armed",
            "t_s": 12.5,
            "monotonic_s": 5012.5,
            "unix_s": 1.7e9 + 5012.5,
            "autopilot": {"boot_t_s": -3.25, "uncertainty_s": 0.004},
        }
    ]


def test_in_lockstep_there_is_no_machines_clock_and_at_first_no_autopilots(tmp_path: Path) -> None:
    ClockFile(tmp_path, False, write).add(ClockReading("start", 0.0, None, None))
    (sample,) = samples(tmp_path)
    assert (sample["monotonic_s"], sample["unix_s"], sample["autopilot"]) == (None, None, None)


@pytest.mark.parametrize("is_continued", [False, True])
def test_a_run_that_goes_on_keeps_its_samples(tmp_path: Path, is_continued: bool) -> None:
    ClockFile(tmp_path, False, write).add(ARMED)
    ClockFile(tmp_path, is_continued, write).add(ARMED._replace(occasion="end"))
    assert [s["at"] for s in samples(tmp_path)] == ["armed", "end"][1 - is_continued :]


@pytest.mark.parametrize("text", ["", "{", "[]", '{"samples": 1}', '{"samples": [1]}'])
def test_a_damaged_file_is_no_file(tmp_path: Path, text: str) -> None:
    (tmp_path / "clocks.json").write_text(text)
    assert read_clocks(tmp_path) == []


def test_a_disk_that_is_full_ends_no_flight(tmp_path: Path) -> None:
    told: list[Any] = []
    folder = RunFolder(tmp_path / "run", mission("F at(A)"), 0.0, told.append)
    (tmp_path / "run" / "clocks.json").mkdir()
    folder.clocks(ARMED)
    folder.close()
    assert len(told) == 1


def test_a_flight_has_its_clocks_read_when_it_begins_arms_and_ends(surveillance_run: Path) -> None:
    start, armed, end = samples(surveillance_run)
    assert [start["at"], armed["at"], end["at"]] == ["start", "armed", "end"]
    assert start["autopilot"] is None
    for sample in (armed, end):  # both begin to count in the same tick
        assert abs(sample["autopilot"]["boot_t_s"]) <= sample["autopilot"]["uncertainty_s"] + 0.01


def test_each_arming_marks_the_autopilots_log() -> None:
    """Also at a level at which nothing but errors is told."""
    asked = mission("F at(A)")
    flight = Lockstep(asked, world_of(asked, {"version": 1, "lidar": {}}))
    flight.companion._component._texts.level = ERROR
    flight.until_the_end()
    texts = [s for s in flight.said if s.message.get_type() == "STATUSTEXT"]
    marks = [s for s in texts if s.message.text == "run the-run"]
    assert len(marks) == flight.armings == 1


def test_a_mark_is_whole_and_never_too_late() -> None:
    queue = StatusTextQueue()
    queue.mark("run " + "2026-11-21T101500-" + "x" * CHUNK_BYTES)
    (first,), (second,) = queue.due(100.0), queue.due(100.1)
    assert first.id == second.id > 0
    assert (first.text + second.text).endswith("x")
