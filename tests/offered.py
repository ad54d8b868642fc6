"""Packages that offer functions, written where a test says, as `pip install --target` does it."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path

import pytest

from companion.skills.authoring import FunctionKind

TEMPLATE = Path(__file__).parents[1] / "docs" / "examples" / "scale_skill"


def offer(
    folder: Path,
    name: str,
    code: str,
    skills: str,
    others: Mapping[FunctionKind, str] | None = None,
) -> None:
    """A package of one module with the skills that are named, each by the function of its name."""
    (folder / f"{name}.py").write_text(code, encoding="utf-8")
    about = folder / f"{name}-1.0.dist-info"
    about.mkdir()
    (about / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: 1.0\n")
    lines = []
    for kind, names in {FunctionKind.SKILL: skills, **(others or {})}.items():
        lines += [f"[{kind.value}]", *(f"{each} = {name}:{each}" for each in names.split())]
    (about / "entry_points.txt").write_text("\n".join(lines) + "\n")


def installed_in(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """What lies in a folder is installed, for the programs that a test starts."""
    monkeypatch.setenv("PYTHONPATH", str(folder), prepend=os.pathsep)


def install_template(folder: Path) -> None:
    """Installs the template package with pip, from a copy and without a network."""
    copied = folder / "source"
    subprocess.run(["cp", "-r", str(TEMPLATE), str(copied)], check=True)
    pip = [sys.executable, "-m", "pip", "install", "--quiet", "--disable-pip-version-check"]
    alone = ["--no-deps", "--no-build-isolation", "--no-index"]
    subprocess.run([*pip, *alone, "--target", str(folder / "site"), str(copied)], check=True)
