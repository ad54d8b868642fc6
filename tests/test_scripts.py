"""scripts/fly, scripts/test and their environment, with a Python that only notes what it is asked.

What the commands of the documentation need of it is shown where they are run:
`first_installation.py` hides the rest from them.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from first_installation import environment, hidden_modules, shown_extras

ROOT = Path(__file__).parents[1]
TOOLS = ("bash", "cat", "chmod", "cmp", "cp", "dirname", "flock", "mkdir", "mktemp", "nice", "rm")

PYTHON = """#!/usr/bin/env bash
# Is new enough, makes environments that hold itself and our tools, installs by a note.
log="${BASH_SOURCE[0]%/*}/../../log"
case "$*" in
    "-m venv --clear "*)
        mkdir -p "$4/bin"
        cp "${BASH_SOURCE[0]}" "$4/bin/python"
        for tool in companion ruff mypy lint-imports; do
            echo "echo $tool" '"$@"' >"$4/bin/$tool"
            chmod +x "$4/bin/$tool"
        done
        ;;
    "-m pip install "*)
        echo "${@: -1}" >>"$log"
        ;;
    "-m pytest "*)
        echo "${@:2}"
        ;;
esac
"""
SHOWN = "planners"
"""The extras that the commands of the documentation need."""
NO_VENV = '#!/usr/bin/env bash\n[[ "$*" != *ensurepip* ]]\n'


@pytest.fixture
def clone(tmp_path: Path) -> Path:
    """A repository with the scripts, in a folder with a space; ../bin is all of the path."""
    folder = tmp_path / "a clone"
    shutil.copytree(ROOT / "scripts", folder / "scripts")
    (folder / "pyproject.toml").write_text("[project]\n", encoding="utf-8")
    (tmp_path / "bin").mkdir()
    for name in TOOLS:
        found = shutil.which(name)
        if found:
            (tmp_path / "bin" / name).symlink_to(found)
    return folder


def provide(clone: Path, script: str) -> None:
    """Puts a python3 on the path."""
    python = clone.parent / "bin" / "python3"
    python.write_text(script, encoding="utf-8")
    python.chmod(0o755)


def start(clone: Path, *arguments: str, script: str = "fly") -> subprocess.Popen[str]:
    """A script, from another folder."""
    return subprocess.Popen(
        ["bash", str(clone / "scripts" / script), *arguments],
        cwd=clone.parent,
        env={"PATH": str(clone.parent / "bin")},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def fly(clone: Path, *arguments: str) -> tuple[str, str]:
    """What scripts/fly prints, and what it tells on standard error."""
    process = start(clone, *arguments)
    out, err = process.communicate(timeout=600)
    assert process.returncode == 0, err
    return out, err


def installations(clone: Path) -> list[str]:
    return (clone / "log").read_text(encoding="utf-8").splitlines()


def test_the_first_use_installs_and_the_second_does_not(clone: Path) -> None:
    provide(clone, PYTHON)
    out, err = fly(clone, "--speed", "max")
    assert out == f"companion sim {clone}/missions/surveillance.yaml --speed max\n"
    assert len(err.splitlines()) == 1
    assert "installing" in err
    for mission in ("other.yaml", "other.yml", "surveillance"):
        assert fly(clone, mission, "--help") == (f"companion sim {mission} --help\n", "")
    assert installations(clone) == [f"{clone}[{SHOWN}]"]


def test_a_changed_project_is_installed_again(clone: Path) -> None:
    provide(clone, PYTHON)
    fly(clone)
    (clone / "pyproject.toml").write_text("[project]\nname = 'new'\n", encoding="utf-8")
    fly(clone)
    assert installations(clone) == [f"{clone}[{SHOWN}]"] * 2


def test_a_moved_repository_is_installed_anew(clone: Path) -> None:
    """Otherwise the copy would run the code of the original."""
    provide(clone, PYTHON)
    fly(clone)
    copy = shutil.copytree(clone, clone.parent / "copy")
    fly(copy)
    assert installations(copy) == [f"{clone}[{SHOWN}]", f"{copy}[{SHOWN}]"]


@pytest.mark.skipif(
    shutil.which("flock") is None, reason="without flock, as on macOS, scripts do not wait"
)
def test_two_at_once_install_once(clone: Path) -> None:
    provide(clone, PYTHON)
    for process in [start(clone), start(clone)]:
        process.communicate(timeout=600)
        assert process.returncode == 0
    assert installations(clone) == [f"{clone}[{SHOWN}]"]


@pytest.mark.parametrize(
    ("python", "reason"),
    [
        (None, "none was found"),
        ("#!/usr/bin/env bash\nexit 1\n", "none was found"),  # too old, or pyenv's shim
        (NO_VENV, "python3 has no venv module (on Debian and Ubuntu: apt install python3-venv)"),
    ],
)
def test_without_a_usable_python_it_says_so(clone: Path, python: str | None, reason: str) -> None:
    if python:
        provide(clone, python)
    process = start(clone)
    out, err = process.communicate(timeout=600)
    assert (process.returncode, out) == (1, "")
    assert err == f"Python 3.11 or newer is needed: {reason}\n"
    assert not (clone / ".venv").exists()


@pytest.mark.long
@pytest.mark.slow
def test_what_only_the_tests_need_is_hidden_from_the_commands(tmp_path: Path) -> None:
    """So a command that needs more than scripts/fly installs fails in its test."""
    assert shown_extras() == set(SHOWN.split(","))
    hidden, without = hidden_modules(shown_extras()), hidden_modules([])
    assert {"hypothesis", "mypy", "playwright", "pytest"} <= hidden
    assert not {"companion", "numpy", "psutil", "unified_planning", "up_fast_downward"} & hidden
    assert {"up_fast_downward", "up_pyperplan"} <= without
    script = "import numpy, psutil\ntry: import pytest\nexcept ModuleNotFoundError: print('none')"
    done = subprocess.run(
        [sys.executable, "-c", script],
        env=os.environ | environment(tmp_path),
        capture_output=True,
        text=True,
        timeout=60,
        check=True,
    )
    assert done.stdout == "none\n"


LINT, CHECKS = ["ruff check .", "ruff format --check ."], ["mypy", "lint-imports --no-logo"]
ALL_CORES = "pytest --quiet --numprocesses logical --dist worksteal -m "
ALONE = "alone and not long"
APART = "--override-ini cache_dir=.pytest_cache/sockets"
AT_ONCE = f"{APART} --numprocesses 4 --dist worksteal"
NOT_READ = "--ignore tests/flights --ignore tests/browser --ignore tests/properties"
"""Folders without a fast test, which take seconds to import."""
FAST = "not flight and not slow and not sockets and not long"


@pytest.mark.parametrize(
    ("arguments", "ran"),
    [
        (
            [],
            [
                *LINT,
                f"{ALL_CORES}not sockets and not long and not soak",
                *CHECKS,  # begun before, told when both have ended
            ],
        ),
        (
            ["--sockets", "-x"],
            [
                f"pytest --quiet {AT_ONCE} -m sockets and not {ALONE} tests/test_a.py "
                "tests/test_b.py -x",
                f"pytest --quiet -m sockets and {ALONE} tests/test_b.py -x",
            ],
        ),
        (
            ["--all"],
            [
                f"pytest --quiet {AT_ONCE} -m sockets and not {ALONE} tests/test_a.py "
                "tests/test_b.py",
                *LINT,  # from here to the checks as without an argument, told when all has ended
                f"{ALL_CORES}not sockets and not long and not soak",
                *CHECKS,
                f"pytest --quiet -m sockets and {ALONE} tests/test_b.py",
            ],
        ),
        (["--fast"], [*LINT, *CHECKS, f"{ALL_CORES}{FAST} {NOT_READ}"]),
        (["--fast", "-k", "lasso"], [*LINT, *CHECKS, f"{ALL_CORES}{FAST} {NOT_READ} -k lasso"]),
        (["-m", "sockets"], ["pytest -m sockets"]),
    ],
)
def test_what_the_tests_are_asked_for(clone: Path, arguments: list[str], ran: list[str]) -> None:
    """As `scripts/test --fast`, and without it."""
    provide(clone, PYTHON)
    has_tests(clone)
    process = start(clone, *arguments, script="test")
    out, err = process.communicate(timeout=60)
    assert process.returncode == 0, err
    assert out.splitlines() == ran
    assert installations(clone) == [f"{clone}[{SHOWN},test]"]


def test_what_fails_beside_others_is_run_again_alone(clone: Path) -> None:
    told = 'echo "${@:2}"\n        ;;\nesac'
    assert told in PYTHON
    provide(clone, PYTHON.replace(told, 'echo "${@:2}"; [[ "$*" != *numprocesses* ]];;\nesac'))
    has_tests(clone)
    process = start(clone, "--sockets", script="test")
    out, err = process.communicate(timeout=60)
    assert process.returncode == 0, err
    assert out.splitlines() == [
        f"pytest --quiet {AT_ONCE} -m sockets and not {ALONE} tests/test_a.py tests/test_b.py",
        "again, one at a time:",
        f"pytest --quiet {APART} --last-failed -m sockets and not {ALONE} tests/test_a.py "
        "tests/test_b.py",
        f"pytest --quiet -m sockets and {ALONE} tests/test_b.py",
    ]


def test_of_both_at_once_either_may_fail(clone: Path) -> None:
    """The tests that fly nothing in real time have failed; what is measured is not begun then."""
    told = 'echo "${@:2}"\n        ;;\nesac'
    provide(clone, PYTHON.replace(told, 'echo "${@:2}"; [[ "$*" != *logical* ]];;\nesac'))
    has_tests(clone)
    process = start(clone, "--all", script="test")
    out, _ = process.communicate(timeout=60)
    assert process.returncode == 1
    assert out.splitlines() == [
        f"pytest --quiet {AT_ONCE} -m sockets and not {ALONE} tests/test_a.py tests/test_b.py",
        *LINT,
        f"{ALL_CORES}not sockets and not long and not soak",
    ]


def has_tests(clone: Path) -> None:
    """Two files over sockets, of which one is flown alone, and one that is not read for them."""
    (clone / "tests").mkdir()
    for name, marks in (("a", ["sockets"]), ("b", ["sockets", "alone"]), ("c", [])):
        text = "".join(f"@pytest.mark.{mark}\n" for mark in marks)
        (clone / "tests" / f"test_{name}.py").write_text(text, "utf-8")


@pytest.mark.long
@pytest.mark.slow
def test_what_flies_and_what_is_slow_is_not_fast() -> None:
    """By folder, by hand, by a fixture, by an import."""
    not_fast = {
        "tests/flights/test_surveillance.py",
        "tests/properties/test_ltl.py",
        "tests/test_bench.py",
        "tests/test_cli_audit.py",
        "tests/unit/sitl/test_autopilot.py",
    }
    fast = {"tests/test_architecture.py", "tests/unit/ltl/test_hoa.py", "companion/geometry.py"}
    command = [sys.executable, "-m", "pytest", "--collect-only", "-q", "-m", FAST]
    done = subprocess.run(
        [*command, *not_fast, *fast],
        cwd=ROOT,
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    collected = {line.partition("::")[0] for line in done.stdout.splitlines() if "::" in line}
    assert collected == fast, done.stdout
