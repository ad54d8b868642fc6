"""`companion plan` as a user meets it: what if, other objectives, other planners, PDDL, JSON."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from commands import Companion

from companion.planning.effort import Effort

SURVEILLANCE = Path(__file__).parents[1] / "missions" / "surveillance.yaml"
WITHOUT_SITES = [f"--without=canUpload(r{i})" for i in (1, 2, 3)]


def test_json_says_what_was_asked_and_what_it_took(companion: Companion) -> None:
    answer = json.loads(companion("plan", SURVEILLANCE, "--at", "A", "--json").out)
    assert answer["version"] == 1
    assert answer["mission"] == "surveillance"
    assert answer["prefix"] == []
    assert answer["loop"][0] | {"cost_s": 0} == {
        "action": "move(A, B)",
        "skill": "move",
        "arguments": ["A", "B"],
        "cost_s": 0,
    }
    assert answer["cost_s"] == answer["bound_s"] == answer["lap_cost_s"]
    assert (answer["objective"], answer["optimal"], answer["engine"]) == ("lap", True, "built-in")
    assert set(answer["times_ms"]) == {"translate", "ground", "search"}
    assert [part["conjunct"] for part in answer["automata"]] == [
        *["search"] * 3,
        "upload",
        "return",
    ]
    assert answer["state"]["facts"] == ["at(A)"]
    assert len(answer["state"]["automata"]) == len(answer["automata"])
    assert answer["reason"] is None


def test_json_says_why_there_is_no_plan(companion: Companion) -> None:
    ended = companion("plan", SURVEILLANCE, "--set", "targetFound", *WITHOUT_SITES, "--json")
    assert ended.code == 3
    answer = json.loads(ended.out)
    assert (answer["prefix"], answer["loop"]) == (None, None)
    assert [part["name"] for part in answer["reason"]["conflict"]] == ["upload"]
    assert answer["reason"]["unreachable"][0]["fact"] == "targetReported"
    assert answer["reason"]["restoring"] == [f"canUpload(r{i})" for i in (1, 2, 3)]
    assert answer["state"]["withdrawn"] == answer["reason"]["withdrawn"]


@pytest.mark.slow
@pytest.mark.parametrize("command", ["plan", "check"])
def test_a_search_that_is_given_up_is_told_from_no_plan(
    companion: Companion, monkeypatch: pytest.MonkeyPatch, command: str
) -> None:
    tiny = Effort(5, 5, 5, 5, 5)
    monkeypatch.setattr("companion.planning.solver.BEFORE_FLIGHT", tiny)
    ended = companion(command, SURVEILLANCE)
    assert ended.code == 7
    assert ended.err.startswith("the search was given up at its limit of 5 edges of the product")
    assert "there may be a plan\n" in ended.err
    assert "--engine fast-downward" in ended.err
    as_json = companion(command, SURVEILLANCE, "--json")
    assert as_json.code == 7
    if command == "check":
        assert json.loads(as_json.out)["exit_code"] == 7


@pytest.mark.parametrize("objective", ["lap", "sum", "bottleneck"])
def test_each_objective_is_said_and_proved(companion: Companion, objective: str) -> None:
    ended = companion("plan", SURVEILLANCE, "--objective", objective)
    assert ended.code == 0
    assert f"{objective} " in ended.out
    assert "optimal (built-in)" in ended.out


@pytest.mark.slow
@pytest.mark.parametrize(
    ("engine", "encoding"), [("fast-downward", "v4"), ("fast-downward", "v5"), ("pyperplan", "v5")]
)
def test_another_planner(companion: Companion, engine: str, encoding: str) -> None:
    chosen = ["--engine", engine, "--encoding", encoding, "--objective", "sum", "--json"]
    answer = json.loads(companion("plan", SURVEILLANCE, *chosen).out)
    best = json.loads(companion("plan", SURVEILLANCE, "--objective", "sum", "--json").out)
    assert answer["engine"] == f"{engine} {encoding}"
    if engine == "fast-downward":
        assert answer["bound_s"] is None and not answer["optimal"]
        assert answer["cost_s"] == best["cost_s"]


@pytest.mark.slow
def test_a_planner_that_says_there_is_no_plan(companion: Companion) -> None:
    """The reason is the built-in search's; it would also notice if the other one were wrong."""
    state = ["--set", "targetFound", *WITHOUT_SITES]
    ended = companion("plan", SURVEILLANCE, *state, "--engine", "fast-downward")
    assert ended.code == 3
    assert "upload cannot hold" in ended.err


@pytest.mark.slow
@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--engine", "nobody"], "there is no engine nobody; installed are: fast-downward"),
        (["--engine", "pyperplan"], "use encoding v5"),
        (["--engine", "symk"], "pip install up-symk"),
        (["--engine", "fast-downward", "--objective", "bottleneck"], "minimise the bottleneck"),
    ],
)
def test_a_planner_that_cannot(companion: Companion, options: list[str], message: str) -> None:
    """It is a mistake of who asked for it, as one that is not there."""
    ended = companion("plan", SURVEILLANCE, *options)
    assert ended.code == 2
    assert message in ended.err


@pytest.mark.slow
@pytest.mark.parametrize("command", ["sim", "run"])
@pytest.mark.parametrize(
    ("mission", "engine", "message"),
    [
        ("surveillance", "nobody", "there is no engine nobody; installed are: fast-downward"),
        ("surveillance", "pyperplan", "cannot take encoding v4"),
        ("night_watch", "fast-downward", "knows of no bounds in time"),
        ("endless_patrol", "fast-downward", "knows of no energy"),
    ],
)
def test_no_flight_begins_with_a_planner_that_cannot_plan_it(
    companion: Companion,
    tmp_path: Path,
    command: str,
    mission: str,
    engine: str,
    message: str,
) -> None:
    ended = companion(command, mission, "--engine", engine, "--monitor", "off")
    assert ended.code == 2
    assert message in ended.err
    assert not (tmp_path / "runs").exists()


@pytest.mark.slow
@pytest.mark.parametrize("encoding", ["v1", "v4", "v5"])
def test_pddl_is_written(companion: Companion, tmp_path: Path, encoding: str) -> None:
    folder = tmp_path / "new" / "folder"
    ended = companion("plan", SURVEILLANCE, "--pddl", folder, "--encoding", encoding)
    assert ended.out.split() == [str(folder / "domain.pddl"), str(folder / "problem.pddl")]
    assert "(define (domain" in (folder / "domain.pddl").read_text()
    assert "(define (problem" in (folder / "problem.pddl").read_text()


def test_pddl_where_nothing_can_be_written(companion: Companion, tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    ended = companion("plan", SURVEILLANCE, "--pddl", tmp_path / "file" / "below")
    assert ended.code == 1
    assert "cannot write to" in ended.err


TWO_LINES = """\
version: 1
name: dropped
map: {east_m: [-2, 12], north_m: [-2, 12]}
limits: {speed_mps: 2, up_m: [0.5, 4], fence: [[-1, -1], [11, -1], [11, 11], [-1, 11]]}
places:
  Home: {east_m: 0, north_m: 0, up_m: 2}
  A: {east_m: 5, north_m: 0, up_m: 2}
sets: {Place: [Home, A]}
skills:
  move:
    parameters: {from: Place, to: Place}
    precondition: at(from)
    effect: at(to) & !at(from)
    execute: fly(to)
initially: [at(Home)]
task:
  stay: G at(Home)
  visit: {formula: F at(A), priority: 3}
"""


def test_what_a_plan_drops_is_told(companion: Companion, tmp_path: Path) -> None:
    path = tmp_path / "dropped.yaml"
    path.write_text(TWO_LINES)
    told = companion("plan", path).out.partition("dropped    ")[2].splitlines()
    assert told[:2] == ["visit: no plan keeps it", "  stay, visit cannot hold together from here."]
    answer = json.loads(companion("plan", path, "--json").out)
    assert answer["dropped"] == [{"line": "visit", "reason": "no plan keeps it"}]
    checked = companion("check", path).out.splitlines()
    assert "task       visit: 2 states, priority 3" in checked
    assert "dropped    visit: no plan keeps it" in checked
    assert json.loads(companion("check", path, "--json").out)["dropped"] == [told[0]]


def test_pddl_has_the_lines_that_are_kept(companion: Companion, tmp_path: Path) -> None:
    path = tmp_path / "dropped.yaml"
    path.write_text(TWO_LINES)
    companion("plan", path, "--pddl", tmp_path / "two")
    path.write_text(TWO_LINES.replace("  visit: {formula: F at(A), priority: 3}\n", ""))
    companion("plan", path, "--pddl", tmp_path / "one")
    for name in ("domain.pddl", "problem.pddl"):
        assert (tmp_path / "two" / name).read_text() == (tmp_path / "one" / name).read_text()
