"""What `companion check --contingencies` prints, draws and exits with."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest
from commands import Companion

from companion import load_mission
from companion.api import contingency_answers
from companion.api.contingency_answers import contingencies

MISSIONS = Path(__file__).parents[1] / "missions"
SURVEILLANCE = str(MISSIONS / "surveillance.yaml")
ASKED = ("check", "--contingencies", "--jobs", "1")
SUMMARY = "60 contingencies: 48 planned, 12 end at Home, 0 unsafe"
SHORT = """\
version: 1
name: far
limits: {speed_mps: 5, up_m: [1, 15], fence: [[-20, -20], [220, -20], [220, 20], [-20, 20]]}
battery: {reserve: 5, capacity_wh: 3.5}
places:
  Home: {east_m: 0, north_m: 0, up_m: 6}
  Away: {east_m: 100, north_m: 0, up_m: 6}
sets: {Place: [Home, Away]}
skills:
  move:
    parameters: {from: Place, to: Place}
    precondition: at(from)
    assumes: trans_ok(from, to)
    effect: at(to) & !at(from)
    execute: fly(to)
initially: [at(Home)]
task: {visit: "F at(Away) & F G at(Home)"}
"""


NEAR = SHORT.replace("east_m: 100", "east_m: 10").replace(
    "{reserve: 5, capacity_wh: 3.5}", "{reserve: 15, capacity_wh: 70}"
)


@pytest.fixture
def near(tmp_path: Path) -> str:
    """A small mission without an unsafe contingency."""
    path = tmp_path / "near.yaml"
    path.write_text(NEAR, encoding="utf-8")
    return str(path)


def test_it_prints_the_table(companion: Companion) -> None:
    ended = companion(*ASKED, SURVEILLANCE)
    lines = ended.out.splitlines()
    assert (ended.code, lines[-2:]) == (0, [SUMMARY, "ok"])
    assert any("no way to A; no way to B; no way to C" in line for line in lines)
    assert any(line.split() == ["1", "A", "move(A,", "B)", "(loop)"] for line in lines)


def test_json_has_it_beside_the_rest(companion: Companion, near: str) -> None:
    told = json.loads(companion(*ASKED, "--json", near).out)
    many = len(told["contingencies"]["contingencies"])
    assert many > 1 and told["ok"]
    assert told["contingencies"]["summary"].startswith(f"{many} contingencies: ")


@pytest.mark.long
def test_the_picture_is_drawn(companion: Companion, tmp_path: Path, near: str) -> None:
    picture = tmp_path / "table.png"
    assert companion(*ASKED, "--picture", str(picture), near).code == 0
    assert picture.read_bytes().startswith(b"\x89PNG")
    nowhere = companion(*ASKED, "--picture", str(tmp_path / "no" / "table.png"), near)
    assert (nowhere.code, "cannot draw" in nowhere.err) == (1, True)


def test_an_unsafe_contingency_is_the_exit_code(companion: Companion, tmp_path: Path) -> None:
    mission = tmp_path / "far.yaml"
    mission.write_text(SHORT, encoding="utf-8")
    ended = companion(*ASKED, str(mission))
    assert ended.code == 8
    assert ended.out.splitlines()[-1] == "1 unsafe"


def test_a_flight_tells_the_summary_first(companion: Companion, near: str) -> None:
    ended = companion("sim", near, "--contingencies", "--speed", "max")
    assert re.match(r"otherwise  \d+ contingencies: .*, 0 unsafe\n", ended.out)
    assert ended.code == 0


@pytest.mark.parametrize("command", ["sim", "run"])
def test_no_flight_begins_with_an_unsafe_contingency(
    companion: Companion, tmp_path: Path, command: str
) -> None:
    path = tmp_path / "short.yaml"
    path.write_text(SHORT)
    ended = companion(command, str(path), "--contingencies", "--log-dir", str(tmp_path / "runs"))
    assert ended.code == 8
    assert "not flown: the charge does not last" in ended.err
    assert not (tmp_path / "runs").exists()


@pytest.mark.parametrize("others", [(), (SURVEILLANCE, "--resume")])
def test_a_flight_that_may_be_in_the_air_makes_no_table(
    companion: Companion, others: tuple[str, ...]
) -> None:
    ended = companion("run", *others, "--contingencies")
    assert ended.code == 2 and "no --resume" in " ".join(ended.err.split())


@pytest.mark.parametrize("option", [("--picture", "table.png"), ("--jobs", "2")])
def test_its_options_go_with_it(companion: Companion, option: tuple[str, str]) -> None:
    ended = companion("check", *option, SURVEILLANCE)
    assert (ended.code, "goes with --contingencies" in ended.err) == (2, True)


def test_a_tree_by_hand_is_refused(companion: Companion) -> None:
    ended = companion(*ASKED, str(MISSIONS / "by_hand.yaml"))
    assert ended.code == 2
    assert "a tree of its own, which nothing replaces in flight" in ended.err


def test_ctrl_c_keeps_nothing(companion: Companion, monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupted(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("companion.cli.contingencies.contingencies", interrupted)
    ended = companion(*ASKED, SURVEILLANCE)
    assert (ended.code, "nothing of it is kept" in ended.err) == (1, True)


@pytest.mark.slow
def test_two_processes_make_the_same_table(monkeypatch: pytest.MonkeyPatch) -> None:
    mission, told = load_mission(SURVEILLANCE), list[tuple[int, int]]()
    monkeypatch.setattr(contingency_answers, "FEW_ANSWERS", 0)
    alone = contingencies(mission, jobs=1)
    assert contingencies(mission, jobs=2, on_progress=lambda *so_far: told.append(so_far)) == alone
    assert told[-1] == (48, 48) and told == sorted(told)
