"""The commands as a user meets them: what they print, and with which exit code they end."""

from __future__ import annotations

import importlib.util
import json
import re
import shutil
import socket
import subprocess
import sys
import tomllib
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

import pytest
from commands import Companion
from ports import free_instance

from companion.acting.preparation import PreparedMission, prepare
from companion.cli.flying import run
from companion.errors import LinkError
from companion.flights.monitor_page import PageOptions
from sitl.link.server import Server

MISSIONS = Path(__file__).parents[1] / "missions"
SURVEILLANCE = MISSIONS / "surveillance.yaml"


Spoil = Callable[[str, str], Path]


@pytest.fixture
def spoil(tmp_path: Path) -> Spoil:
    """A copy of the surveillance mission with its map, in which one text is replaced."""

    def replaced(old: str, new: str) -> Path:
        folder = shutil.copytree(MISSIONS, tmp_path / "missions")
        path = folder / SURVEILLANCE.name
        text = path.read_text(encoding="utf-8")
        assert text.count(old) == 1
        path.write_text(text.replace(old, new), encoding="utf-8")
        return path

    return replaced


@pytest.fixture
def taken_port() -> Iterator[int]:
    """A UDP port that another program has."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as other:
        other.bind(("127.0.0.1", 0))
        yield other.getsockname()[1]


@pytest.fixture
def free_port() -> int:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as finder:
        finder.bind(("127.0.0.1", 0))
        port: int = finder.getsockname()[1]
    return port


SIGNING = ("--signing-key", "--unsigned-vehicle")
OPTIONS = {
    "check": ["--within", "--contingencies", "--picture", "--jobs", "--json", "--verbose"],
    "new": ["--space", "--task", "--home"],
    "runs": ["--log-dir", "--newest", "--prune", "--yes"],
    "doctor": ["--connect", "--instance", "--log-dir"],
    "plan": [
        *("--at", "--set", "--unset", "--without", "--objective"),
        *("--engine", "--encoding", "--timeout", "--pddl", "--json", "--verbose"),
    ],
    "tree": ["--format", "--verbose"],
    "skills": ["--json"],
    "ltl": ["--format", "--state-based", "--monolithic", "--batch", "--exclusive"],
    "run": [
        *(
            "--connect",
            *SIGNING,
            "--accept-weak-failsafes",
            "--autopilot-fence",
            "--rally-points",
            "--wait",
            "--resume",
            "--events",
            "--laps",
            "--limit-s",
            "--contingencies",
            "--timeout",
        ),
        *("--engine", "--encoding", "--engine-timeout", "--log-dir", "--monitor", "--verbose"),
    ],
    "sim": [
        *("--scenario", "--speed", "--seed", "--instance", "--ground-port", "--events"),
        *("--laps", "--limit-s", "--contingencies", "--timeout"),
        *("--engine", "--encoding", "--engine-timeout", "--engine-duration"),
        *("--log-dir", "--monitor", "--verbose"),
    ],
    "campaign": [
        *("--runs", "--seed", "--scenario", "--jobs", "--limit-s", "--out", "--resume", "--dask"),
        "--against",
    ],
    "falsify": [
        *("--budget", "--seed", "--scenario", "--jobs", "--limit-s", "--out", "--resume", "--dask"),
    ],
    "audit": ["--json"],
    "export": ["--output", "--home"],
    "figure": ["--format", "--output"],
    "import": ["--output", "--home", "--up-m", "--payload", "--leave-out", "--name"],
    "replay": ["--port", "--open", "--mcap"],
    "upload": ["--connect", "--system", *SIGNING, "--start", "--timeout", "--verbose"],
    "key": [],
    "watch": ["--connect", "--system", *SIGNING, "--timeout", "--verbose"],
}


@pytest.mark.parametrize("command", OPTIONS)
def test_help_names_the_options(command: str, companion: Companion) -> None:
    ended = companion(command, "--help")
    assert ended.code == 0
    assert set(re.findall(r"^.\s+(?:\*\s+)?(--[a-z-]+)", ended.out, re.MULTILINE)) == {
        *OPTIONS[command],
        "--help",
    }


def test_help_names_the_commands(companion: Companion) -> None:
    ended = companion("--help")
    assert ended.code == 0
    assert set(re.findall(r"^│ ([a-z]+) ", ended.out, re.MULTILINE)) == OPTIONS.keys()


def test_the_version_is_that_of_the_project(companion: Companion) -> None:
    pyproject = tomllib.loads((MISSIONS.parent / "pyproject.toml").read_text(encoding="utf-8"))
    ended = companion("--version")
    assert (ended.code, ended.err) == (0, "")
    assert ended.out == f"companion {pyproject['project']['version']}\n"


def test_check_prints_the_task_and_the_plan(companion: Companion) -> None:
    ended = companion("check", SURVEILLANCE)
    assert ended.code == 0
    assert "upload: 2 states" in ended.out
    assert "move(Home, A), (move(A, B), move(B, C), move(C, A))^w" in ended.out
    assert ended.out.endswith("ok\n")


def test_the_last_line_of_a_check_has_what_is_noticed(companion: Companion, spoil: Spoil) -> None:
    unused = '\nevents:\n  spare: {when: "EVENT[spare] > 0"}\n'
    ended = companion("check", spoil("\nevents:\n", unused))
    assert ended.code == 0
    assert ended.out.endswith("no skill\nok, with 1 notice\n")


def test_plan_prints_the_same_for_people_and_for_programs(companion: Companion) -> None:
    ended = companion("plan", SURVEILLANCE, "--json")
    assert ended.code == 0
    plan = json.loads(ended.out)
    assert [step["action"] for step in plan["prefix"]] == ["move(Home, A)"]
    assert [s["action"] for s in plan["loop"]] == ["move(A, B)", "move(B, C)", "move(C, A)"]
    assert plan["lap_cost_s"] == pytest.approx(sum(step["cost_s"] for step in plan["loop"]))
    printed = companion("plan", SURVEILLANCE).out
    for step in (*plan["prefix"], *plan["loop"]):
        assert re.search(rf"{re.escape(step['action'])} +{step['cost_s']:.1f} s", printed)


def test_ltl_prints_an_automaton(companion: Companion) -> None:
    ended = companion("ltl", "G F at(A)")
    assert ended.code == 0
    assert ended.out.startswith("HOA: v1\n")
    assert 'AP: 1 "at(A)"' in ended.out
    assert ended.out.endswith("--END--\n")


def test_a_wrong_formula_is_shown_with_a_caret(companion: Companion) -> None:
    ended = companion("ltl", "G (a &)")
    assert ended.code == 2
    text, caret = ended.err.splitlines()[1:3]
    assert text.index(")") == caret.index("^")


class Mistake(NamedTuple):
    """A mistake in a mission file: `old` becomes `new`, and the message points to `at`."""

    old: str
    new: str
    at: str
    message: str


MISTAKES = {
    "unknown key": Mistake("name: surv", "nam: surv", "nam: surv", "Did you mean name?"),
    "unknown place in a set": Mistake("[Home, A, B", "[Home, D, B", "D, B", "unknown place D"),
    "unknown place in the task": Mistake(
        "F (at(A) |", "F (at(D) |", "at(D)", "Did you mean at(A)?"
    ),
    "formula": Mistake("F (at(A) |", "F (at(A |", "| targetFound) &", "expected a comma or )"),
    "place in a wall": Mistake("3, north_m: 11", "6, north_m: 7.7", "A: {", "is in a wall"),
    "place outside the fence": Mistake(
        "[21.5, 13.5], [-1.5, 13.5]", "[21.5, 10.7], [-1.5, 10.7]", "A: {", "outside the fence"
    ),
}


@pytest.mark.parametrize("name", MISTAKES)
def test_a_mistake_is_answered_with_its_place(
    name: str, companion: Companion, spoil: Spoil
) -> None:
    mistake = MISTAKES[name]
    path = spoil(mistake.old, mistake.new)
    before, _, _ = path.read_text(encoding="utf-8").partition(mistake.at)
    line, column = before.count("\n") + 1, len(before) - before.rfind("\n")
    ended = companion("check", path)
    assert ended.code == 2
    assert ended.err.startswith(f"{path}:{line}:{column}: ")
    assert mistake.message in ended.err
    assert ended.out == ""


def test_a_missing_mission(companion: Companion, tmp_path: Path) -> None:
    ended = companion("check", tmp_path / "none.yaml")
    assert ended.code == 2
    assert f"there is no file {tmp_path / 'none.yaml'}" in ended.err


def test_a_missing_scenario(companion: Companion, tmp_path: Path) -> None:
    scenario = tmp_path / "none.sim.yaml"
    ended = companion("sim", SURVEILLANCE, "--scenario", scenario, "--speed", "max")
    assert ended.code == 2
    assert f"{scenario} cannot be read" in ended.err
    assert not (tmp_path / "runs").exists()


def test_a_speed_that_is_none(companion: Companion) -> None:
    ended = companion("sim", SURVEILLANCE, "--speed", "fast")
    assert ended.code == 2
    assert "fast is not a positive number or max" in ended.err


@pytest.mark.slow
@pytest.mark.parametrize("command", [("check",), ("plan",), ("sim", "--speed", "max")])
def test_a_task_without_a_plan_names_the_conflict(
    command: tuple[str, ...], companion: Companion, spoil: Spoil
) -> None:
    path = spoil("\ntask:\n", "\ntask:\n  never_a: G !at(A)\n")
    name, *options = command
    ended = companion(name, path, *options)
    assert ended.code == 3
    assert "no plan: never_a, search cannot hold together" in ended.err


@pytest.mark.slow
def test_no_vehicle(companion: Companion, free_port: int) -> None:
    url = f"udpin://127.0.0.1:{free_port}"
    ended = companion("run", SURVEILLANCE, "--connect", url, "--timeout", 1)
    assert ended.code == 4
    assert f"no vehicle on {url} after 1 s: nothing arrived" in ended.err
    assert f"4  no vehicle on {url}" in companion("runs").out
    assert "PX4 SITL" in ended.err


def test_a_bare_udp_url_is_answered_with_both_corrections(companion: Companion) -> None:
    ended = companion("run", SURVEILLANCE, "--connect", "udp://192.168.1.10:14540")
    assert ended.code == 2
    assert "udpin://192.168.1.10:14540" in ended.err
    assert "udpout://192.168.1.10:14540" in ended.err


@pytest.mark.slow
@pytest.mark.parametrize("command", ["run", "sim"])
def test_an_address_of_reports_that_is_none_is_refused_before_anything_begins(
    companion: Companion, command: str
) -> None:
    ended = companion(command, SURVEILLANCE, "--events", "foo")
    assert (ended.code, ended.out) == (2, "")
    assert "cannot hear reports on foo\n    write unix:/run/companion/events, or" in ended.err


@pytest.mark.slow
def test_reports_that_a_mission_reads_and_nobody_hears_are_noticed(companion: Companion) -> None:
    nowhere = "--connect", "udp://192.168.1.10:14540"
    notice = "notice     not heard: EVENT[person]; --events says where other programs report"
    assert notice in companion("run", "lost_person", *nowhere).out
    assert "notice" not in companion("run", "lost_person", *nowhere, "--events", "unix:a").out
    assert "notice" not in companion("run", SURVEILLANCE, *nowhere).out


@pytest.mark.parametrize("command", [("run", SURVEILLANCE), ("upload", SURVEILLANCE), ("watch",)])
def test_a_port_in_use(
    companion: Companion, taken_port: int, command: tuple[str | Path, ...]
) -> None:
    """As of a watch on the port of an upload."""
    url = f"udpin://127.0.0.1:{taken_port}"
    ended = companion(*command, "--connect", url)
    assert ended.code == 4
    assert f"cannot listen on {url}" in ended.err
    assert "another program has the port" in ended.err


@pytest.mark.slow
def test_the_module_is_the_command(tmp_path: Path) -> None:
    """Exit code and streams of a process of its own."""
    done = subprocess.run(
        [sys.executable, "-m", "companion", "check", str(tmp_path / "none.yaml")],
        capture_output=True,
        text=True,
        timeout=600,
        check=False,
    )
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.startswith("there is no file ")


SLOW_TO_IMPORT = {"jsbsim", "matplotlib", "numpy", "pydantic", "pymavlink", "scipy"}


def test_help_does_not_wait_for_slow_imports() -> None:
    assert all(importlib.util.find_spec(name) for name in SLOW_TO_IMPORT)
    script = "import sys, companion.cli; print(*sys.modules)"
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, timeout=600, check=True
    )
    imported = set(done.stdout.split())
    assert "companion.cli" in imported
    assert not SLOW_TO_IMPORT & imported


def test_a_machine_without_jsbsim(companion: Companion, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("sitl.installed.find_spec", lambda name: None)
    ended = companion("sim", SURVEILLANCE)
    assert ended.code == 2
    assert "needs jsbsim" in ended.err and "pip install jsbsim" in ended.err


def test_a_machine_without_dask(
    companion: Companion, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr("companion.campaigns.dask_cluster.find_spec", lambda name: None)
    about = ("campaign", "corridor", "--runs", "1", "--out", tmp_path / "out")
    ended = companion(*about, "--dask", "tcp://127.0.0.1:8786")
    assert ended.code == 2
    assert "pip install 'mav-companion[cluster]'" in ended.err


@pytest.mark.slow
def test_a_simulator_that_cannot_start(companion: Companion) -> None:
    """Another one has the ports; that one must not be flown in its place."""
    instance = free_instance()
    with Server(instance):
        ended = companion("sim", SURVEILLANCE, "--instance", instance)
    assert ended.code == 4
    assert "the simulator did not start" in ended.err
    assert "another simulator may run" in ended.err


def test_plan_answers_what_if(companion: Companion) -> None:
    ended = companion(
        "plan", SURVEILLANCE, "--at", "r1", "--set", "targetFound", "--without", "canUpload(r1)"
    )
    assert ended.code == 0
    assert re.findall(r"\w+\(.*?\)|wait", ended.out) == [
        "move(r1, r2)",
        "upload(r2)",
        "move(r2, Home)",
        "wait",
    ]


def test_plan_says_why_there_is_none(companion: Companion) -> None:
    sites = [f"--without=canUpload(r{i})" for i in (1, 2, 3)]
    ended = companion("plan", SURVEILLANCE, "--set", "targetFound", *sites)
    assert ended.code == 3
    assert "upload cannot hold" in ended.err
    assert "with canUpload(r1) or canUpload(r2) or canUpload(r3)" in ended.err


def test_a_mission_is_prepared_before_the_link_is_opened(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """So nothing is timed meanwhile, and no vehicle waits for a plan."""
    done = []

    def prepare_first(*arguments: Any, **options: Any) -> PreparedMission:
        done.append("prepared")
        return prepare(*arguments, **options)

    def no_link(*arguments: object) -> None:
        done.append("link")
        raise LinkError("nothing is flown here")

    monkeypatch.setattr("companion.run_sources.only_run.prepare", prepare_first)
    monkeypatch.setattr("companion.flights.options.Link", no_link)
    with pytest.raises(LinkError):
        run(SURVEILLANCE, log_dir=tmp_path, monitor=PageOptions(is_on=False))
    assert done == ["prepared", "link"]
