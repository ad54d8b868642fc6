"""Programs that are started are those that are installed, whatever lies in the folder."""

from __future__ import annotations

import subprocess
from pathlib import Path

import pytest

from companion.python_child import python_module


@pytest.mark.parametrize("module", ["companion", pytest.param("sitl", marks=pytest.mark.long)])
def test_nothing_of_the_working_directory_is_run(module: str, tmp_path: Path) -> None:
    for name in ("companion", "sitl", "typer"):
        (tmp_path / f"{name}.py").write_text("raise SystemExit(99)", encoding="utf-8")
    done = subprocess.run(
        python_module(module, "--help"), cwd=tmp_path, capture_output=True, check=False
    )
    assert done.returncode == 0, done.stderr
    assert b"Usage" in done.stdout
