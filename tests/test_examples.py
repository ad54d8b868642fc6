"""The examples of docs/examples: each does what its first lines say, whatever folder it is in."""

from __future__ import annotations

import ast
import doctest
import os
import re
import runpy
import shutil
import subprocess
import sys
import sysconfig
import venv
from pathlib import Path

import pytest

import companion

ROOT = Path(__file__).parents[1]
pytestmark = pytest.mark.slow
EXAMPLES = sorted((ROOT / "docs" / "examples").glob("*.py"))
RUN_LONG = {"audit_a_log", "batch_of_seeds", "own_costs", "what_if"}
"""What they call is tested by itself; others of every run plan and fly."""
LEAVES = {
    "audit_a_log": "run/events.jsonl",
    "draw_an_automaton": "automaton.png",
    "simulate_and_plot": "flight.png",
}
"""Files that an example makes."""


def told(example: Path) -> list[str]:
    """What the example's docstring says that it prints; numbers may differ between machines."""
    tree = ast.parse(example.read_text(encoding="utf-8"))
    docstring = ast.get_docstring(tree) or ""
    return without_numbers(docstring.partition("\n\n")[2].splitlines())


def without_numbers(lines: list[str]) -> list[str]:
    return [" ".join(re.sub(r"\d+(\.\d+)?", "0", line).split()) for line in lines]


def run(python: Path, example: Path, folder: Path) -> list[str]:
    """What the example prints in a folder, in a process of its own."""
    done = subprocess.run(
        [python, example], cwd=folder, capture_output=True, text=True, timeout=300, check=False
    )
    assert (done.returncode, done.stderr) == (0, "")
    return without_numbers(done.stdout.splitlines())


def test_there_are_eight() -> None:
    assert len(EXAMPLES) == 8
    assert all(len(path.read_text(encoding="utf-8").splitlines()) <= 45 for path in EXAMPLES)


@pytest.mark.parametrize(
    "example",
    [
        pytest.param(path, marks=[pytest.mark.long] if path.stem in RUN_LONG else [])
        for path in EXAMPLES
    ],
    ids=lambda path: path.stem,
)
def test_an_example_does_what_it_says(
    example: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    """In this process, which has loaded what an example takes most of its time to load."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "argv", [str(example)])
    runpy.run_path(str(example), run_name="__main__")
    out, err = capsys.readouterr()
    assert (without_numbers(out.splitlines()), err) == (told(example), "")
    if example.stem in LEAVES:
        assert (tmp_path / LEAVES[example.stem]).stat().st_size > 0


def test_what_the_page_shows_of_python_is_so(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(ROOT)
    failed, attempted = doctest.testfile(str(ROOT / "docs/python.md"), module_relative=False)
    assert attempted > 0
    assert failed == 0


def test_the_page_names_every_export_that_is_a_verb_and_every_example() -> None:
    page = (ROOT / "docs" / "python.md").read_text(encoding="utf-8")
    verbs = [name for name in companion.__all__ if not isinstance(getattr(companion, name), type)]
    assert all(f"`{verb}(" in page for verb in verbs)
    assert all(f"(examples/{path.name})" in page for path in EXAMPLES)


@pytest.fixture(scope="module")
def installed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Python of a new environment with the built wheel, and what it depends on from this one."""
    source = tmp_path_factory.mktemp("source")
    for name in ("pyproject.toml", "README.md", "LICENSE"):
        shutil.copy(ROOT / name, source)
    for package in ("companion", "sitl", "missions"):
        shutil.copytree(ROOT / package, source / package)
    pip = [sys.executable, "-m", "pip", "--quiet", "--disable-pip-version-check"]
    wheel = ["wheel", "--no-deps", "--wheel-dir", str(source / "dist"), str(source)]
    subprocess.run([*pip, *wheel], check=True, timeout=300)
    (built,) = (source / "dist").glob("*.whl")
    environment = tmp_path_factory.mktemp("environment")
    venv.create(environment, with_pip=False)
    python = environment / "bin" / "python"
    install = ["--python", str(python), "install", "--no-deps", str(built)]
    subprocess.run([*pip, *install], check=True, timeout=300)
    (packages,) = (environment / "lib").glob("python*/site-packages")
    (packages / "dependencies.pth").write_text(sysconfig.get_path("purelib") + "\n")
    return python


@pytest.mark.long
def test_the_wheel_is_what_is_imported(installed: Path, tmp_path: Path) -> None:
    script = "import companion, sitl; print(companion.__file__); print(sitl.__file__)"
    done = subprocess.run(
        [installed, "-c", script], cwd=tmp_path, capture_output=True, text=True, check=True
    )
    assert all(Path(line).is_relative_to(installed.parents[1]) for line in done.stdout.split())


@pytest.mark.long
def test_shipped_missions_have_names_wherever_it_is_installed(
    installed: Path, tmp_path: Path
) -> None:
    def ran(*arguments: str) -> subprocess.CompletedProcess[str]:
        command = [str(installed.with_name("companion")), *arguments]
        state = {**os.environ, "XDG_STATE_HOME": str(tmp_path / "state")}
        return subprocess.run(
            command, cwd=tmp_path, env=state, capture_output=True, text=True, check=False
        )

    for mission in sorted((ROOT / "missions").glob("*.yaml")):
        if not mission.name.endswith(".sim.yaml"):
            checked = ran("check", mission.stem)
            assert checked.returncode == 0, checked.stderr
    flown = ran("sim", "return_home", "--speed", "max")
    assert (flown.returncode, flown.stderr) == (0, "")
    assert list((tmp_path / "state" / "companion").glob("*-return_home/flight.png"))
    assert "did you mean surveillance?" in ran("check", "surveilance").stderr


@pytest.mark.long
@pytest.mark.parametrize("example", EXAMPLES, ids=lambda path: path.stem)
def test_an_example_runs_from_the_wheel(example: Path, installed: Path, tmp_path: Path) -> None:
    copy = shutil.copy(example, tmp_path)
    assert run(installed, Path(copy), tmp_path) == told(example)
