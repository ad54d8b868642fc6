"""What a release is installed with: every package that the project asks for, with its hashes."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

ROOT = Path(__file__).resolve().parents[1]
PINS = (ROOT / "scripts/requirements.txt").read_text(encoding="utf-8")
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
ASKED = [*PROJECT["dependencies"], *PROJECT["optional-dependencies"]["planners"]]
PINNED = re.findall(
    r"^([A-Za-z0-9._-]+)==(\S+)(.*(?:\n    --hash=sha256:[0-9a-f]{64}.*)*)", PINS, re.M
)


@pytest.mark.parametrize("asked", [Requirement(text) for text in ASKED], ids=str)
def test_what_the_project_asks_for_is_pinned(asked: Requirement) -> None:
    """In a version that will do; run scripts/pin after a change of pyproject.toml."""
    versions = [
        version
        for name, version, _ in PINNED
        if canonicalize_name(name) == canonicalize_name(asked.name)
    ]
    assert versions and all(asked.specifier.contains(version) for version in versions)


def test_nothing_is_pinned_without_hashes() -> None:
    """pip refuses the whole file otherwise."""
    assert len(PINNED) == len(re.findall(r"^[A-Za-z0-9._-]+==", PINS, re.M))
    assert all(rest.count("--hash=sha256:") >= 1 for *_, rest in PINNED)
