"""Mistakes of strangers (mistakes.py): each answer names the place and a remedy."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

import pytest
from commands import Companion
from mistakes import FIELD, IN_WORDS, MISSIONS, WORLD, WORLDS, Mistake
from several_mistakes import TOGETHER, WORLDS_TOGETHER

from companion import load_mission
from companion.errors import MissionError
from sitl.world.scenario import read_scenario

HOME = "  home: F G at(Home)"
IN_FILES = [
    pytest.param(right, mistake, id=f"{kind}: {name}")
    for kind, (right, table) in MISSIONS.items()
    for name, mistake in table.items()
]


def written(right: str, mistake: Mistake, path: Path) -> str:
    """The file with the mistake, which is written there."""
    assert mistake.right in right
    text = right.replace(mistake.right, mistake.wrong, 1)
    path.write_text(text, encoding="utf-8")
    return text


def check(answer: str, text: str, mistake: Mistake, path: Path) -> None:
    """It names the line, and what to do."""
    assert mistake.words in answer
    named = re.match(rf"{re.escape(str(path))}:(\d+):\d+: .*\n +\S", answer)
    assert named, answer
    line = text.splitlines()[int(named[1]) - 1]
    assert line.startswith(mistake.line) if mistake.line else named[1] in ("1", "8"), answer


@pytest.mark.parametrize(("right", "mistake"), IN_FILES)
def test_the_answer_names_the_place_and_a_remedy(
    right: str, mistake: Mistake, tmp_path: Path
) -> None:
    text = written(right, mistake, tmp_path / "first.yaml")
    with pytest.raises(MissionError) as error:
        load_mission(tmp_path / "first.yaml")
    check(str(error.value), text, mistake, tmp_path / "first.yaml")
    assert len(error.value.each) == 1  # and nothing that follows from it


@pytest.mark.parametrize("name", WORLDS)
def test_so_do_the_answers_about_worlds(name: str, tmp_path: Path) -> None:
    text = written(WORLD, WORLDS[name], tmp_path / "first.sim.yaml")
    with pytest.raises(MissionError) as error:
        read_scenario(tmp_path / "first.sim.yaml")
    check(str(error.value), text, WORLDS[name], tmp_path / "first.sim.yaml")


@pytest.mark.parametrize("name", IN_WORDS)
def test_a_line_that_never_holds_is_told_with_what_to_write(
    name: str, companion: Companion, tmp_path: Path
) -> None:
    text = written(FIELD, IN_WORDS[name], tmp_path / "first.yaml")
    ended = companion("check", tmp_path / "first.yaml")
    assert ended.code == 3
    line = text.splitlines().index(IN_WORDS[name].wrong) + 1
    assert f"(line {line})" in ended.err and IN_WORDS[name].words in ended.err


COMMANDS = {
    "check frist.yaml": "did you mean first.yaml?",
    "check surveilance": "did you mean surveillance?",
    "check first.sim.yaml": "companion sim first.yaml flies",
    "check .": "is a folder: name a file in it",
    "check": "Missing argument 'MISSION'",
    "chek first.yaml": "Did you mean 'check'?",
    "first.yaml": "companion sim first.yaml flies it",
    "fly first.yaml": "write sim, in the simulator, or run, on a vehicle",
    "sim first.yaml --monitor localhost": "neither HOST:PORT nor off",
    "upload first.sim.yaml": "companion sim first.yaml flies",
    "sim first.yaml --speed fast": "not a positive number or max",
    "sim first.yaml --instance 300": "less than or equal to",
    "sim first.yaml --scenario first.yaml --speed max": "MISSION.sim.yaml",
    "run first.yaml --connect /dev/ttyUSB0": "write serial:///dev/ttyUSB0:57600",
    "run first.yaml --connect 14540": "write udpin://0.0.0.0:14540",
    "run first.yaml --connect udp://10.0.0.2:14540": "write udpin://10.0.0.2:14540",
    "plan first.yaml --at Hmoe": "Did you mean Home?",
    "plan first.yaml --objective fastest": "is not one of 'lap'",
    "audit first.yaml": "a run folder holds events.jsonl",
    "audit runs": "give one of them, e.g. runs/2026-11-21T101500-first",
    "replay runs/2026-11-21T101500-first/events.jsonl": "give its folder: runs/2026",
    "figure nowhere": "companion runs lists them",
    "new first": "is there already",
    "new 2nd": "letters, digits and _, a letter first",
    "new other --space indoor --task patrol": "is not one of 'hall'",
    "import field.plan": "Missing option '--output'",
    "export first.yaml -o first.txt": "neither .plan nor .geojson",
    "runs --log-dir nowhere": "companion sim surveillance makes one",
}
"""Command -> what its answer has to say. Each is exit code 2 but for runs, and links."""


def test_commands_that_are_mistaken_are_answered_with_what_to_give(
    companion: Companion, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "first.yaml").write_text(FIELD)
    (tmp_path / "first.sim.yaml").write_text(WORLD)
    (tmp_path / "runs" / "2026-11-21T101500-first").mkdir(parents=True)
    (tmp_path / "runs" / "2026-11-21T101500-first" / "events.jsonl").touch()
    for command, words in COMMANDS.items():
        ended = companion(*command.split())
        told = " ".join(ended.err.replace("│", " ").split())
        assert words in told, f"{command}\n{ended.err}"
        expected = 1 if "--log-dir" in command else 2
        assert ended.code == expected, command
    shutil.rmtree(tmp_path / "runs")


def test_an_empty_file(tmp_path: Path) -> None:
    (tmp_path / "first.yaml").write_text("")
    with pytest.raises(MissionError, match="companion new NAME writes a mission"):
        load_mission(tmp_path / "first.yaml")


def told_in(error: MissionError, folder: Path) -> list[str]:
    """What is wrong, without the places."""
    lines = [line for line in str(error).splitlines() if line.startswith(str(folder))]
    return [re.sub(r"^.*?:\d+:\d+: ", "", line) for line in lines]


def with_mistakes(right: str, changes: dict[str, str], path: Path) -> None:
    for had, has in changes.items():
        assert had in right, had
        right = right.replace(had, has, 1)
    path.write_text(right, encoding="utf-8")


@pytest.mark.parametrize(("right", "changes", "told"), TOGETHER.values(), ids=TOGETHER)
def test_one_run_tells_all_mistakes_of_a_mission_and_no_others(
    right: str, changes: dict[str, str], told: list[str], tmp_path: Path
) -> None:
    with_mistakes(right, changes, tmp_path / "first.yaml")
    with pytest.raises(MissionError) as error:
        load_mission(tmp_path / "first.yaml")
    assert told_in(error.value, tmp_path) == told


@pytest.mark.parametrize(("changes", "told"), WORLDS_TOGETHER.values(), ids=WORLDS_TOGETHER)
def test_so_does_one_of_a_world(changes: dict[str, str], told: list[str], tmp_path: Path) -> None:
    with_mistakes(WORLD, changes, tmp_path / "first.sim.yaml")
    with pytest.raises(MissionError) as error:
        read_scenario(tmp_path / "first.sim.yaml")
    assert told_in(error.value, tmp_path) == told


def test_many_mistakes_are_told_by_the_first_ones(tmp_path: Path) -> None:
    unknown = "".join(f"extra_{number}: 1\n" for number in range(50))
    (tmp_path / "first.yaml").write_text(FIELD + unknown)
    with pytest.raises(MissionError) as error:
        load_mission(tmp_path / "first.yaml")
    assert str(error.value).count("unknown key") == 10
    assert str(error.value).endswith("and 40 more mistakes")


def test_lines_that_contradict_each_other_are_told_with_their_lines(
    companion: Companion, tmp_path: Path
) -> None:
    path = tmp_path / "first.yaml"
    path.write_text(FIELD.replace(HOME, "  home: G at(Home)\n  out: F at(A)"), encoding="utf-8")
    lines = path.read_text(encoding="utf-8").splitlines()
    for command in ("check", "plan"):
        ended = companion(command, path)
        assert ended.code == 3
        told = re.findall(r"^  (\w+): .*  \(line (\d+)\)$", ended.err, re.MULTILINE)
        assert len(told) == 2
        assert all(lines[int(number) - 1].startswith(f"  {name}:") for name, number in told)
