"""`companion audit` of recorded flights; test_cli_audit_records.py has records written by hand."""

from __future__ import annotations

import json
import re
import shutil
from pathlib import Path
from typing import TypeVar

import pytest
from audited import outcomes
from commands import Companion

from companion.api.simulating import simulate
from companion.flight_events.event import FlightEvent
from companion.flight_events.facts import MissionEventChanged
from companion.flight_events.plans import NoPlanFound
from companion.flight_events.reading import read_line
from companion.flight_events.skills import PlaceReached, SkillCompleted
from companion.flight_events.sortie import ReturnBegun, RunFailed
from companion.flight_events.word import ConjunctViolated, PositionLeft
from companion.ltl.formula import Formula
from companion.ltl.semantics import holds
from companion.mission.loader import load_mission

ROOT = Path(__file__).parents[1]
MISSIONS = ROOT / "missions"
DOCUMENTED = "companion audit runs/2026-11-21T101500-surveillance"
"""The command in docs/run-folder.md."""
E = TypeVar("E", bound=FlightEvent)


def fly(mission: Path, folder: Path) -> Path:
    """A flight of a mission in the surveillance mission's world; its run folder."""
    simulate(load_mission(mission), MISSIONS / "surveillance.sim.yaml", folder=folder)
    return folder


@pytest.fixture(scope="module")
def good(surveillance_run: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return shutil.copytree(surveillance_run, tmp_path_factory.mktemp("good") / "run")


@pytest.fixture(scope="module")
def bad(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The same, but the target must not be found, which the vehicle cannot choose."""
    folder = shutil.copytree(MISSIONS, tmp_path_factory.mktemp("missions") / "missions")
    path = folder / "surveillance.yaml"
    text = path.read_text(encoding="utf-8")
    path.write_text(text.replace("\ntask:\n", "\ntask:\n  calm: G !targetFound\n"))
    return fly(path, tmp_path_factory.mktemp("bad"))


def events(run: Path) -> list[FlightEvent]:
    return [read_line(line).event for line in (run / "events.jsonl").read_text().splitlines()]


def of(run: Path, kind: type[E]) -> list[E]:
    return [event for event in events(run) if isinstance(event, kind)]


def test_the_surveillance_mission_is_satisfied(companion: Companion, good: Path) -> None:
    code, found = outcomes(companion, good)
    assert code == 0
    assert found == dict.fromkeys(["search", "upload", "return"], ("satisfied", None))
    answer = json.loads(companion("audit", good, "--json").out)
    assert answer["at_rest"] and not answer["torn"] and answer["differs"] == []
    assert answer["ending"] == "task satisfied, landed"
    places = [re.findall(r"at\((\w+)\)", " ".join(p["facts"])) for p in answer["positions"]]
    way = ["Home", "A", "B", "C", "A", "r1", "r2", "r2", "Home", "Home"]
    assert places == [[place] for place in way]
    assert not any(p["restarted"] for p in answer["positions"])


def test_the_paper_s_task_is_violated_over_the_whole_flight_and_satisfied_since(
    companion: Companion, section_v_run: Path
) -> None:
    assert outcomes(companion, section_v_run)[0] == 0
    answer = json.loads(companion("audit", section_v_run, "--json").out)
    assert [p["number"] for p in answer["positions"] if p["restarted"]] == [5]
    told = {(c["formula"], c["since"], c["outcome"], c["whole"]) for c in answer["conjuncts"][:3]}
    assert told == {
        ("G(F at(A) | targetFound)", 5, "satisfied", "satisfied"),
        ("G(F at(B) | targetFound)", 5, "satisfied", "unfulfilled"),
        ("G(F at(C) | targetFound)", 5, "satisfied", "unfulfilled"),
    }


def test_the_word_in_the_record_satisfies_the_task_of_the_file(good: Path) -> None:
    """The file and the record alone, by the semantics; nothing of the audit takes part."""
    task = load_mission(MISSIONS / "surveillance.yaml").task
    positions = of(good, PositionLeft)
    for name, formula in task.items():
        assert isinstance(formula, Formula)
        begun = max((p.number for p in positions if name in p.restarted), default=0)
        word = [frozenset(p.facts) for p in positions[begun:]]
        assert holds(formula, word[:-1], word[-1:]), name
    word = [frozenset(p.facts) for p in positions]
    upload = task["upload"]
    assert isinstance(upload, Formula)
    assert not holds(upload, word[:6], word[5:6])  # rest at r1 would not have done


@pytest.mark.long
def test_a_tree_written_by_hand_is_held_against_a_task_it_was_not_made_from(
    companion: Companion, tmp_path: Path
) -> None:
    folder = shutil.copytree(MISSIONS, tmp_path / "missions")
    path = folder / "by_hand.yaml"
    task = "\ntask:\n  report: F targetReported\n  never: G !at(C)\n  return: F G at(Home)\n"
    path.write_text(path.read_text(encoding="utf-8") + task, encoding="utf-8")
    run = fly(path, tmp_path / "run")
    code, found = outcomes(companion, run)
    assert code == 6
    done = [e for e in events(run) if isinstance(e, PlaceReached | SkillCompleted)]
    at_c = next(i for i, e in enumerate(done) if isinstance(e, PlaceReached) and e.place == "C")
    assert found == {
        "report": ("fulfilled", done.index(SkillCompleted("upload(r2)")) + 1),
        "never": ("violated", at_c + 1),
        "return": ("satisfied", None),
    }


def test_a_violating_flight_has_the_verdict_that_it_was_told_in_flight(
    companion: Companion, bad: Path
) -> None:
    (told,) = of(bad, ConjunctViolated)
    assert (told.conjunct, told.formula) == ("calm", "G !targetFound")
    code, found = outcomes(companion, bad)
    assert code == 6
    assert found["calm"] == ("violated", told.position)
    assert found["upload"] == ("unfulfilled", None)  # it went home without an upload
    answer = json.loads(companion("audit", bad, "--json").out)
    assert answer["differs"] == []
    column = [c["conjunct"] for c in answer["conjuncts"]].index("calm")
    states = [p["states"][column] for p in answer["positions"]]
    number = told.position
    assert states == ["open"] * number + ["false"] * (len(states) - number)
    assert answer["positions"][number]["facts"] == list(told.facts)


def test_after_a_violation_the_mission_does_what_is_left_and_says_why(bad: Path) -> None:
    told = [event for event in events(bad) if event.is_told]
    found = told.index(MissionEventChanged("targetFound", holds=True))
    no_plan, returning, reached = told[found + 1 : found + 4]
    assert isinstance(no_plan, NoPlanFound) and no_plan.reason == "target found"
    assert no_plan.explanation.startswith("no plan: calm cannot hold from here")
    assert returning == ReturnBegun("Home")
    assert isinstance(reached, PlaceReached) and reached.place == "Home"
    ended = events(bad)[-1]
    assert isinstance(ended, RunFailed) and ended.exit_code == 3


def test_people_and_programs_read_the_same(companion: Companion, bad: Path) -> None:
    ended = companion("audit", bad)
    assert ended.code == 6
    assert "does not satisfy the task: calm, upload" in ended.err
    answer = json.loads(companion("audit", bad, "--json").out)
    rows = re.findall(r"^ +(\d+)  \d\d:\d\d\.\d  ([.TF]+)  (.*?)(?:;.*)?$", ended.out, re.M)
    symbols = {"open": ".", "true": "T", "false": "F"}
    assert rows == [
        (str(p["number"]), "".join(symbols[s] for s in p["states"]), ", ".join(p["facts"]))
        for p in answer["positions"]
    ]
    for conjunct in answer["conjuncts"]:
        line = next(x for x in ended.out.splitlines() if x.endswith(conjunct["formula"]))
        assert line.startswith(conjunct["conjunct"])


def test_the_documented_command(
    companion: Companion, good: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert DOCUMENTED in (ROOT / "docs" / "run-folder.md").read_text(encoding="utf-8")
    _, command, run = DOCUMENTED.split()
    shutil.copytree(good, tmp_path / run)
    monkeypatch.chdir(tmp_path)
    assert companion(command, run).code == 0
