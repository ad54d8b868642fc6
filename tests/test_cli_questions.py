"""`companion new` asks whoever sits at a terminal."""

from __future__ import annotations

import os
import pty
import subprocess
import sys
from pathlib import Path

from companion.mission.loader import load_mission


def test_a_mission_is_made_by_answers(tmp_path: Path) -> None:
    leader, terminal = pty.openpty()
    os.write(leader, b"moon\nfield\ninspection\n")
    command = [sys.executable, "-m", "companion", "new", "mine"]
    made = subprocess.run(command, cwd=tmp_path, stdin=terminal, capture_output=True, text=True)
    assert made.returncode == 0, made.stderr
    os.close(leader)
    os.close(terminal)
    assert "moon is not one of hall, field, earth" in made.stdout + made.stderr
    mission = load_mission(tmp_path / "mine.yaml")
    assert mission.grid.is_open
