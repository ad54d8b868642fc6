"""What docs/installing.md says of packages is what pyproject.toml has; scripts/packages builds."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

ROOT = Path(__file__).parents[1]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
PAGE = (ROOT / "docs" / "installing.md").read_text(encoding="utf-8")
SCRIPT = (ROOT / "scripts" / "packages").read_text(encoding="utf-8")


def test_each_extra_is_told() -> None:
    told = re.findall(r"^\| `(\w+)` \|", PAGE, re.MULTILINE)
    assert sorted(told) == sorted(PROJECT["project"]["optional-dependencies"])


def test_the_python_versions_are_those_that_are_asked_for() -> None:
    asked = re.search(r"^untested=\((.*)\)$", SCRIPT, re.MULTILINE)
    assert asked and f"| {', '.join(asked[1].split())} |" in PAGE


def test_the_file_has_the_version_of_the_project() -> None:
    files = set(re.findall(r"mav_companion-(\S+?)-py3", PAGE))
    assert files == {PROJECT["project"]["version"]}


def test_what_is_shipped_is_there() -> None:
    for patterns in PROJECT["tool"]["setuptools"]["data-files"].values():
        assert all(any(ROOT.glob(pattern)) for pattern in patterns)
