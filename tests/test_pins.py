"""What a release is installed with: every package that the project asks for, with its hashes."""

from __future__ import annotations

import re
import subprocess
import sys
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


RASPBERRY_PI = {
    "implementation_name": "cpython",
    "os_name": "posix",
    "platform_machine": "aarch64",
    "platform_python_implementation": "CPython",
    "platform_system": "Linux",
    "python_full_version": "3.11.2",
    "python_version": "3.11",
    "sys_platform": "linux",
}
"""Debian 12, as Raspberry Pi OS of 2023 and JetPack 7."""
COMPILED = {"ruckig"}
"""What has no wheel there (docs/real-vehicle.md)."""


@pytest.mark.sockets
def test_a_raspberry_pi_finds_wheels(tmp_path: Path) -> None:
    """Downloaded by pip with the hashes: 100 MB. What is compiled there is named in the docs."""
    wanted = []
    for text in re.sub(r"\\\n\s*", "", PINS).splitlines():
        asked, *hashes = text.split(" --hash=")
        if not hashes or Requirement(asked).name in COMPILED:
            continue
        marker = Requirement(asked).marker
        if marker is None or marker.evaluate(RASPBERRY_PI):
            wanted.append(" --hash=".join([asked.partition(";")[0].strip(), *hashes]))
    assert len(wanted) > len(ASKED)
    pins = tmp_path / "pins.txt"
    pins.write_text("\n".join(wanted), encoding="utf-8")
    platforms = ("manylinux2014", "manylinux_2_17", "manylinux_2_28", "manylinux_2_36")
    pip = subprocess.run(
        [
            *(sys.executable, "-m", "pip", "download", "--quiet", "--no-deps", "--require-hashes"),
            *("--only-binary=:all:", "--python-version", "3.11", "--dest", tmp_path / "wheels"),
            *(f"--platform={name}_aarch64" for name in platforms),
            *("--requirement", pins),
        ],
        capture_output=True,
        text=True,
    )
    assert pip.returncode == 0, pip.stderr
    assert len(list((tmp_path / "wheels").glob("*.whl"))) == len(wanted)
