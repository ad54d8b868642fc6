"""What `companion run --resume` refuses to go on with."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace

import pytest
from commands import Companion

from companion.flights import cut_off_runs
from companion.record.events import JOURNAL_FILE

HOP = Path(__file__).parent / "data" / "hop.yaml"


def test_another_mission_than_the_one_that_was_cut_off_is_a_wrong_request(
    companion: Companion, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    begun = SimpleNamespace(mission="first", path="first.yaml", digest="of another mission")
    cut_off = SimpleNamespace(begun=begun)
    monkeypatch.setattr(cut_off_runs, "read_journal", lambda *_: cut_off)
    (tmp_path / "run").mkdir()
    (tmp_path / "run" / JOURNAL_FILE).touch()
    (tmp_path / "latest").write_text("run")
    ended = companion("run", HOP, "--resume", "--log-dir", tmp_path)
    assert ended.code == 2
    assert "was cut off while it flew first, which is not" in ended.err
