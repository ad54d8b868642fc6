"""Where frames were laid is remembered until the computer is restarted."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from companion.geometry import GlobalOrigin
from companion.record.flight_memory_files import flight_memory_in
from companion.record.laid_frame_file import LAID_FRAMES, laid_frames_at
from companion.vehicle.laid_frames import LaidFrames
from companion.vehicle.mission_frame import LaidHome, MissionFrame

INDOORS = LaidHome((1.0, -2.0, 0.5), 488.25, None)
OUTDOORS = LaidHome((1.0, -2.0, 0.5), 488.25, GlobalOrigin(47.1234567, 8.7654321, 487.5))


@pytest.fixture
def boot(tmp_path: Path) -> Path:
    path = tmp_path / "boot_id"
    path.write_text("0a\n", encoding="ascii")
    return path


def frames_in(folder: Path, boot: Path) -> LaidFrames:
    frames = laid_frames_at(folder / LAID_FRAMES, boot)
    assert frames is not None
    return frames


def recalled(folder: Path, boot: Path) -> LaidHome | None:
    frame = MissionFrame()
    frames_in(folder, boot).recall(frame, system=1, boot_s=100.0)
    return frame.laid


def note(folder: Path, boot: Path, laid: LaidHome) -> None:
    frame = MissionFrame()
    frame.recall(laid)
    frames_in(folder, boot).note(frame, system=1, boot_s=100.0)


@pytest.mark.parametrize("laid", [INDOORS, OUTDOORS])
def test_a_frame_is_remembered(laid: LaidHome, tmp_path: Path, boot: Path) -> None:
    folder = tmp_path / "runs"
    assert recalled(folder, boot) is None
    note(folder, boot, laid)
    assert recalled(folder, boot) == laid


def test_not_over_a_restart_of_the_computer(tmp_path: Path, boot: Path) -> None:
    note(tmp_path, boot, INDOORS)
    boot.write_text("0b\n", encoding="ascii")
    assert recalled(tmp_path, boot) is None


@pytest.mark.parametrize(
    "content",
    [
        "",
        "5",
        "[]",
        '["0a", 5]',
        '["0a", [1, 2]]',
        '["0a", [1, 2, NaN, 0, 0, 0]]',
        '["0a", [1, 2, 0, 0, 0, 0, 47.0]]',
        '["0a", [1, 2, 0, 0, 0, null]]',
    ],
)
def test_a_file_that_is_damaged_is_as_if_it_were_not_there(
    content: str, tmp_path: Path, boot: Path
) -> None:
    (tmp_path / LAID_FRAMES).write_text(content, encoding="utf-8")
    assert recalled(tmp_path, boot) is None
    note(tmp_path, boot, OUTDOORS)
    assert recalled(tmp_path, boot) == OUTDOORS


def test_a_computer_whose_boots_are_not_told_apart_remembers_none(tmp_path: Path) -> None:
    assert laid_frames_at(tmp_path / LAID_FRAMES, tmp_path / "none") is None


def test_they_lie_beside_the_run_folders(tmp_path: Path) -> None:
    frames = flight_memory_in(tmp_path).frames
    assert frames is not None, "on Linux"
    frame = MissionFrame()
    frame.recall(INDOORS)
    frames.note(frame, system=1, boot_s=100.0)
    assert json.loads((tmp_path / LAID_FRAMES).read_text(encoding="utf-8"))[1][0] == 1
