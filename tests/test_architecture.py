"""What may import what (DESIGN: downwards only, pure core), as contracts in pyproject.toml.

A contract that cannot fail says nothing, so a copy of both packages is spoilt with one import
per contract, and each contract has to report exactly that import.
"""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]

SPOILERS = {
    "The companion imports downwards only": ("companion/geometry.py", "companion.maps"),
    "The simulator imports downwards only": ("sitl/flight/mixer.py", "sitl.autopilot.modes"),
    "No circles inside packages": ("companion/ltl/automaton.py", "companion.ltl.hoa"),
    "The companion knows the simulator in one command alone": ("companion/app.py", "sitl.results"),
    "The simulator shares with the companion only what both sides speak and read": (
        "sitl/world/payload.py",
        "companion.planning.search",
    ),
    "Those who plan and act do not speak MAVLink": (
        "companion/acting/report.py",
        "companion.mavlink.framing",
    ),
    "Clocks, sockets, files, processes and chance come in through doors": (
        "companion/motion/trajectory.py",
        "random",
    ),
    "Only the composition roots open doors": (
        "companion/acting/sortie.py",
        "companion.vehicle.link",
    ),
    "Each library is met in one place": ("companion/planning/lasso.py", "networkx"),
}
"""Contract -> a file, and an import that the contract forbids there."""


def lint_imports(root: Path) -> subprocess.CompletedProcess[str]:
    """The linter's verdict on the packages in a folder, by that folder's pyproject.toml."""
    linter = "from importlinter.cli import lint_imports_command as main; main()"
    return subprocess.run(
        [sys.executable, "-c", linter, "--no-cache", "--no-logo"],
        cwd=root,
        capture_output=True,
        text=True,
        check=False,
        timeout=120,
        env={"PATH": "", "COLUMNS": "500"},  # one line per verdict
    )


@pytest.fixture(scope="module")
def spoilt(tmp_path_factory: pytest.TempPathFactory) -> str:
    """What the linter says about the spoilt copy."""
    copy = tmp_path_factory.mktemp("spoilt")
    shutil.copy(ROOT / "pyproject.toml", copy)
    for package in ("companion", "sitl"):
        shutil.copytree(ROOT / package, copy / package, ignore=shutil.ignore_patterns("*.pyc"))
    for name, module in SPOILERS.values():
        with (copy / name).open("a", encoding="utf-8") as file:
            file.write(f"\nimport {module}\n")
    verdict = lint_imports(copy)
    assert verdict.returncode == 1, verdict.stdout + verdict.stderr
    return verdict.stdout


def test_the_code_keeps_all_contracts() -> None:
    verdict = lint_imports(ROOT)
    assert verdict.returncode == 0, verdict.stdout + verdict.stderr


def test_every_contract_has_a_spoiler() -> None:
    config = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    assert {c["name"] for c in config["tool"]["importlinter"]["contracts"]} == set(SPOILERS)


@pytest.mark.parametrize("contract", SPOILERS)
def test_a_forbidden_import_is_reported(contract: str, spoilt: str) -> None:
    assert f"{contract} BROKEN" in spoilt
    name, module = SPOILERS[contract]
    importer = name.removesuffix(".py").replace("/", ".")
    report = re.split(rf"^{re.escape(contract)}\n-+$", spoilt, flags=re.MULTILINE)[1]
    report = re.split(r"^-+$", report, flags=re.MULTILINE)[0]
    siblings = f"{importer.rpartition('.')[2]}", f"{module.rpartition('.')[2]}"
    assert f"{importer} -> {module}" in report or all(s in report for s in siblings)
