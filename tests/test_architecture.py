"""What may import what (downwards only, pure core): the contracts of pyproject.toml.

A contract that cannot fail says nothing. So a copy of both packages is spoilt, with one import
for each contract, and each contract has to report it.
"""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path
from typing import NamedTuple

import pytest

ROOT = Path(__file__).parents[1]


class Spoiler(NamedTuple):
    """An import that a contract forbids, and what the linter has to say about it."""

    file: str
    module: str
    report: str


SPOILERS = {
    "The companion imports downwards only": Spoiler(
        "companion/geometry.py",
        "companion.maps",
        "companion.geometry -> companion.maps",
    ),
    "The simulator imports downwards only": Spoiler(
        "sitl/flight/rotors.py",
        "sitl.autopilot.modes",
        "sitl.flight.rotors -> sitl.autopilot.modes",
    ),
    "No circles inside packages": Spoiler(
        "companion/ltl/automaton.py",
        "companion.ltl.hoa",
        "No cycles are allowed in companion.ltl.",
    ),
    "The companion knows the simulator in one module alone": Spoiler(
        "companion/app.py",
        "sitl.results",
        "companion.app -> sitl.results",
    ),
    "The simulator shares with the companion only what both sides speak and read": Spoiler(
        "sitl/world/payload.py",
        "companion.planning.builtin.search",
        "sitl.world.payload -> companion.planning.builtin.search",
    ),
    "Those who plan and act do not speak MAVLink": Spoiler(
        "companion/acting/positions.py",
        "companion.mavlink.framing",
        "companion.acting.positions -> companion.mavlink.framing",
    ),
    "The monitor sees what was recorded, and nothing else": Spoiler(
        "companion/monitor/feed.py",
        "companion.acting.flight",
        "companion.monitor.feed -> companion.acting.flight",
    ),
    "The pure core opens nothing": Spoiler(
        "companion/motion/trajectory.py",
        "socket",
        "companion.motion.trajectory -> socket",
    ),
    "Only the composition roots open doors": Spoiler(
        "companion/acting/sortie/sortie.py",
        "companion.vehicle.link",
        "companion.acting.sortie.sortie -> companion.vehicle.link",
    ),
    "Each large library is met in one place": Spoiler(
        "companion/planning/lasso.py",
        "pymavlink",
        "companion.planning.lasso -> pymavlink",
    ),
}


def lint_imports(folder: Path) -> subprocess.CompletedProcess[str]:
    """The verdict on the packages of a folder, by the folder's own pyproject.toml."""
    linter = "from importlinter.cli import lint_imports_command; lint_imports_command()"
    return subprocess.run(
        [sys.executable, "-c", linter, "--no-cache", "--no-logo"],
        cwd=folder,
        env={"COLUMNS": "500"},  # a verdict stands on one line
        capture_output=True,
        text=True,
        timeout=600,
        check=False,
    )


@pytest.fixture(scope="module")
def verdict_on_spoilt_copy(tmp_path_factory: pytest.TempPathFactory) -> str:
    copy = tmp_path_factory.mktemp("spoilt")
    shutil.copy(ROOT / "pyproject.toml", copy)
    for package in ("companion", "sitl"):
        shutil.copytree(ROOT / package, copy / package)
    for spoiler in SPOILERS.values():
        with (copy / spoiler.file).open("a", encoding="utf-8") as file:
            file.write(f"\nimport {spoiler.module}\n")
    run = lint_imports(copy)
    assert run.returncode == 1, run.stdout + run.stderr
    return run.stdout


def test_the_code_keeps_all_contracts() -> None:
    run = lint_imports(ROOT)
    assert run.returncode == 0, run.stdout + run.stderr


def test_every_contract_is_spoilt_once() -> None:
    config = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    contracts = config["tool"]["importlinter"]["contracts"]
    assert [c["name"] for c in contracts] == list(SPOILERS)


@pytest.mark.parametrize("contract", SPOILERS)
def test_a_forbidden_import_is_reported(contract: str, verdict_on_spoilt_copy: str) -> None:
    assert f"{contract} BROKEN" in verdict_on_spoilt_copy
    parts = re.split(r"^(.+)\n-{10,}$", verdict_on_spoilt_copy, flags=re.MULTILINE)
    reports = dict(zip(parts[1::2], parts[2::2], strict=True))
    assert SPOILERS[contract].report in reports[contract]
