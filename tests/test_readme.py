"""Every command of README.md and docs/ works: it is run here, or a file is named that runs it.

A command is a line of a block that is fenced as sh or console (there, after `$ `). The console
blocks of FOLLOWED build on each other: tests/test_tutorial.py runs them from top to bottom. What a
test cannot do, as it needs root or a vehicle, is fenced without a kind: NOT_HERE says why. Examples
of the commands' help have options that exist.
"""

from __future__ import annotations

import os
import re
import shlex
import shutil
import signal
import subprocess
import sysconfig
from collections.abc import Callable
from pathlib import Path

import pytest
from commands import Companion
from first_installation import environment
from make_options import commands as public_commands
from pictures import UNDRAWN
from ports import free_instance, own_ports

ROOT = Path(__file__).parents[1]
PAGES = {
    page: page.read_text(encoding="utf-8") for page in [ROOT / "README.md", *ROOT.glob("docs/*.md")]
}
FOLLOWED = [ROOT / "docs" / name for name in ("tutorial.md", "how-to.md")]
SCRIPTS = Path(sysconfig.get_path("scripts"))
"""Where `companion` and `sitl` are installed."""

Start = Callable[[str], subprocess.Popen[str]]

DRAWN = "companion sim missions/open_field.yaml --speed max"
"""The command whose flight is drawn, by what is installed; that takes as long as a flight."""

FOREIGN = {".", "cd", "export", "git", "source"}
"""Programs that need no test."""

IN_REAL_TIME = (
    ("companion sim missions/surveillance.yaml --speed 2",),
    (
        "sitl --scenario missions/surveillance.sim.yaml",
        "companion run missions/surveillance.yaml --connect udpin://0.0.0.0:14540",
    ),
)
"""Commands that are flown here for some seconds, side by side; the last one is the companion."""

SIMULATORS = (
    "sitl",
    "sitl --scenario missions/surveillance.sim.yaml --speed 2",
    "sitl --home 48.14,11.57,520 --seed 7 --quiet",
)
"""Commands that run until they are stopped."""

STARTING = (
    "companion new first --space field --task inspection",
    "companion sim first.yaml --speed max",
)
"""Commands that are run here one after another."""

REFUSED = (
    "companion sim missions/surveillance.yaml --speed max "
    "--scenario missions/surveillance_all_uploads_fail.sim.yaml"
)
DONE_ELSEWHERE = {
    "companion plan missions/hall_of_20.yaml --json",
    "companion plan missions/endless_patrol.yaml",
    "companion check missions/surveillance.yaml --contingencies",
}
"""What these do, other tests do in every run; here they are long."""
EXIT_CODES = {REFUSED: 3}
"""Of quick commands that do not end with 0: there is no plan."""

ELSEWHERE = {
    ".venv/bin/python scripts/bench translating planning": "tests/test_bench.py",
    "companion run missions/surveillance.yaml --wait": "tests/flights/test_ground_station.py",
    "companion run missions/surveillance.yaml --resume": "tests/flights/test_sockets.py",
    "companion upload missions/surveillance.yaml --connect udpin://0.0.0.0:14550 --start": (
        "tests/flights/test_uploads.py"
    ),
    "companion watch --connect udpin://0.0.0.0:14550": "tests/flights/test_uploads.py",
    "sitl --scenario missions/surveillance.sim.yaml --signing-key vehicle.key": (
        "tests/flights/test_signed_sockets.py"
    ),
    "companion run --signing-key vehicle.key": ("tests/flights/test_signed_sockets.py"),
    "companion upload missions/surveillance.yaml --start --signing-key vehicle.key": (
        "tests/flights/test_signed_sockets.py"
    ),
    "companion watch --signing-key vehicle.key": ("tests/flights/test_signed_sockets.py"),
    **dict.fromkeys(
        (
            "sitl -i 0 --scenario missions/surveillance.sim.yaml",
            "sitl -i 1 --scenario missions/surveillance.sim.yaml",
            "companion run --connect udpin://0.0.0.0:14540 --log-dir runs/first",
            "companion run --connect udpin://0.0.0.0:14541 --log-dir runs/second",
            "companion upload missions/surveillance.yaml --system 1 --start",
            "companion upload missions/surveillance.yaml --system 2 --start",
            "companion watch --system 2",
        ),
        "tests/flights/test_two_vehicles.py",
    ),
    **dict.fromkeys(
        (
            "companion import field.plan -o field.yaml",
            "companion export field.yaml -o field.geojson",
            "companion export field.yaml -o shown.plan",
        ),
        "tests/test_cli_plans.py",
    ),
    "companion audit runs/2026-11-21T101500-surveillance": "tests/test_cli_audit.py",
    "companion replay runs/2026-11-21T101500-surveillance": "tests/test_cli_replay.py",
    "companion replay runs/2026-11-21T101500-surveillance --mcap surveillance.mcap": (
        "tests/test_cli_replay.py"
    ),
    "scripts/docs": ".ci/run",
    "scripts/packages": ".ci/run",
    "scripts/fly --speed max": ".ci/run",
    "scripts/test": ".ci/run",
    "scripts/test --fast": "tests/test_scripts.py",
}
"""Command -> the file that runs it."""

NOT_HERE = {
    "installing.md": "scripts/packages installs a wheel, and flies from it",
    "real-vehicle.md": "needs root, a clone and a vehicle; tests/test_pins.py looks at the pins",
    "service.md": "needs root and systemd",
    "skills.md": "installs a package; scripts/packages does the same with a copy",
}
"""Pages with blocks of commands that are fenced without a kind, and why no test runs these."""


def commands(text: str) -> list[str]:
    """The commands of all fenced sh and console blocks, one line each, without comments."""
    found = []
    for kind, block in re.findall(r"^```(\S+)\n(.*?)^```$", text, re.MULTILINE | re.DOTALL):
        if kind not in ("sh", "console"):
            continue
        for line in block.replace("\\\n", " ").splitlines():
            if kind == "sh" or line.startswith("$ "):
                words = shlex.split(line.removeprefix("$ "), comments=True)
                found.append(shlex.join(words))
    return [command for command in found if command]


def is_quick(command: str) -> bool:
    """Whether a test may run a command as it stands."""
    if command in STARTING:
        return False
    match shlex.split(command):
        case ["companion" | "sitl", *_, "--help"]:
            return True
        case ["companion", "check" | "key" | "plan" | "ltl" | "tree", *_]:
            return True
        case ["sitl", "--check", _]:
            return True
        case ["companion", "sim", *_]:
            return "--speed max" in command
    return False


TEXTS = PAGES | {page: PAGES[page].replace("```console", "```") for page in FOLLOWED}
COMMANDS = list(dict.fromkeys(c for text in TEXTS.values() for c in commands(text)))
QUICK = [command for command in COMMANDS if is_quick(command)]
MISSIONS = [path.relative_to(ROOT) for path in (ROOT / "missions").glob("*.yaml")]
SHIPPED = [f"companion sim {path} --speed max" for path in MISSIONS]
"""Flown tick by tick in tests/flights/test_shipped.py as well, so not in the default tests."""
ALONE = {DRAWN}
"""Of these, what nothing else flies in a process of its own: tests/flights/test_sockets.py flies
the others over sockets, `.ci/run` that of README.md, and paper_section_v is flown here with a
planner from outside. Those are flown here with the sweeps, and so is endless_patrol, eleven minutes
long."""
FLOWN_ELSEWHERE = {
    *SHIPPED,
    "companion sim missions/surveillance.yaml --speed max --seed 7",  # companion/api/simulating.py
    REFUSED,  # tests/flights/test_shipped.py
    # tests/paper/test_engines_in_flight.py
    "companion sim missions/paper_section_v.yaml --speed max --engine fast-downward --encoding v1",
}
CHECKS = {
    "companion check missions/surveillance.yaml",
    "sitl --check missions/surveillance.sim.yaml",
}
PROCESSES = [c for c in QUICK if c in CHECKS or "sim" in c.split()]
"""Those of each program that take least, and all flights; the others are run in this process."""
FIRST = {tuple(shlex.split(command)[:2]): command for command in reversed(QUICK)}
TOGETHER = [c for c in FIRST.values() if c not in PROCESSES]
"""The first one of each other subcommand."""
ALL_AT_ONCE = """
import shlex, sys
from companion.cli import main
for command in sys.argv[1:]:
    sys.argv = shlex.split(command)
    try:
        main()
    except SystemExit as end:
        assert not end.code, command
"""
"""A program that gives commands one after the other."""


def test_commands_are_found() -> None:
    shell = "```sh\na b   # c\n\nd 'e  f' \\\n  g\n```\n"
    console = "```console\n$ h\nprinted\n```\n"
    assert commands(f"{shell}text\n{console}```\ni\n```\n") == ["a b", "d 'e  f' g", "h"]
    assert any(command.startswith("companion sim") for command in QUICK)


def test_commands_stand_in_blocks_that_say_so() -> None:
    kinds = {kind for text in PAGES.values() for kind in re.findall(r"^```(\S+)$", text, re.M)}
    assert not kinds & {"bash", "shell", "zsh"}, "fence commands as sh or console"


@pytest.fixture
def start(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Start:
    """Starts a command as scripts/fly installs it, where only the missions are."""
    shutil.copytree(ROOT / "missions", tmp_path / "missions")
    monkeypatch.setenv("COMPANION_LOG_DIR", str(tmp_path / "runs"))
    first, undrawn = (
        os.environ | environment(tmp_path / name, more=more)
        for name, more in (("hiding", ""), ("undrawn", UNDRAWN))
    )

    def run(command: str) -> subprocess.Popen[str]:
        program, *arguments = shlex.split(command)
        return subprocess.Popen(
            [SCRIPTS / program, *arguments],
            cwd=tmp_path,
            env=first if command == DRAWN else undrawn,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
        )

    return run


@pytest.mark.slow
@pytest.mark.parametrize(
    "command",
    [
        pytest.param(
            c,
            marks=[
                *([pytest.mark.sockets] if c in FLOWN_ELSEWHERE else []),
                *([pytest.mark.long] if c in SHIPPED and c not in ALONE else []),
            ],
        )
        for c in PROCESSES
    ],
)
def test_a_quick_command_succeeds(command: str, start: Start) -> None:
    process = start(command)
    printed, _ = process.communicate(timeout=600)
    assert process.returncode == EXIT_CODES.get(command, 0), printed
    assert printed


@pytest.mark.slow
@pytest.mark.parametrize(
    "command",
    [
        pytest.param(c, marks=[pytest.mark.long] if c in DONE_ELSEWHERE else [])
        for c in QUICK
        if c not in PROCESSES
    ],
)
def test_a_quick_command_succeeds_in_this_process(
    command: str, companion: Companion, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    shutil.copytree(ROOT / "missions", tmp_path / "missions")
    monkeypatch.chdir(tmp_path)
    program, *arguments = shlex.split(command)
    ended = companion(*arguments)
    assert program == "companion" and ended.code == EXIT_CODES.get(command, 0), ended.err
    assert ended.out


@pytest.mark.slow
def test_nothing_that_only_the_tests_need_is_loaded_by_any_subcommand(start: Start) -> None:
    """A new mission is made and flown, and one command of each other kind is given."""
    process = start(shlex.join(["python", "-c", ALL_AT_ONCE, *TOGETHER, *STARTING]))
    printed, _ = process.communicate(timeout=600)
    assert process.returncode == 0, printed
    assert "task satisfied, landed" in printed


@pytest.mark.sockets
@pytest.mark.parametrize("together", IN_REAL_TIME)
def test_a_command_flies_and_lands_on_ctrl_c(together: tuple[str, ...], start: Start) -> None:
    """As they stand, but on ports of their own."""
    instance = free_instance()
    *others, companion = [start(on_ports_of(instance, command)) for command in together]
    assert companion.stdout is not None
    try:
        printed = ""
        for line in companion.stdout:
            printed += line
            if "flying the task" in line:
                companion.send_signal(signal.SIGINT)
        assert companion.wait(timeout=600) == 0, printed
        assert re.search(r"landing\n.*stopped as asked\n", printed), printed
        for other in others:
            other.send_signal(signal.SIGINT)
            assert other.wait(timeout=600) == 0
    finally:
        for process in (*others, companion):
            process.kill()
            process.communicate()


@pytest.mark.sockets
@pytest.mark.parametrize("command", SIMULATORS)
def test_a_simulator_starts_and_stops(command: str, start: Start) -> None:
    sitl = start(on_ports_of(free_instance(), command))
    assert sitl.stdout is not None
    try:
        assert sitl.stdout.readline().startswith("sitl: vehicle ")
        sitl.send_signal(signal.SIGINT)
        assert sitl.wait(timeout=600) == 0
    finally:
        sitl.kill()
        sitl.communicate()


def on_ports_of(instance: int, command: str) -> str:
    """A command on the ports of an instance of the simulator."""
    if "14540" in command:
        return command.replace("14540", str(14540 + instance))
    return shlex.join([*shlex.split(command), *own_ports(instance)])


def test_every_command_is_covered() -> None:
    ours = [c for c in COMMANDS if shlex.split(c)[0] not in FOREIGN]
    flown = [command for together in IN_REAL_TIME for command in together]
    assert set(ours) == {*QUICK, *STARTING, *flown, *SIMULATORS, *ELSEWHERE}, (
        "let a test run each command, and no other"
    )
    assert set(EXIT_CODES) <= set(QUICK)
    for command, name in ELSEWHERE.items():
        assert command in (ROOT / name).read_text(encoding="utf-8")


def test_commands_that_no_test_runs_have_a_reason() -> None:
    begins = re.compile(r"^\S*\b(?:companion|pip|sitl) ", re.MULTILINE)
    plain = {
        page.name
        for page, text in PAGES.items()
        for kind, block in re.findall(r"^```(\S*)\n(.*?)^```$", text, re.MULTILINE | re.DOTALL)
        if not kind and begins.search(block)
    }
    assert plain == set(NOT_HERE)
    for reason in NOT_HERE.values():
        assert all((ROOT / name).exists() for name in re.findall(r"\w+/[\w./]+\w", reason))


def test_examples_of_the_help_have_options_that_exist() -> None:
    options = {
        path: {opt for parameter in command.params for opt in parameter.opts}
        for path, command in public_commands().items()
    }
    text = PAGES[ROOT / "docs" / "options.md"]
    examples = re.findall(r"^  ((?:companion|sitl) \S.*)$", text, re.M)
    assert len(examples) > 15
    for example in examples:
        typed = re.split(r" [|>] ", re.sub(r"\$\(.*?\)", "", example))[0]
        known = next(opts for path, opts in options.items() if f"{typed} ".startswith(f"{path} "))
        assert set(re.findall(r"(?<= )--[a-z-]+", typed)) <= known, example


def links() -> list[tuple[Path, str]]:
    return [
        (page, link)
        for page, text in PAGES.items()
        for link in sorted(set(re.findall(r"\]\((?!https?:)([^)#]+)", text)))
    ]


@pytest.mark.parametrize(("page", "link"), links(), ids=str)
def test_a_link_leads_to_a_file(page: Path, link: str) -> None:
    assert (page.parent / link).exists()
