"""Mistakes that people make in their first missions: each answer names the place and a remedy."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from commands import Companion

from companion import load_mission
from companion.errors import MissionError
from companion.plans.starter import StarterSpace, starter
from companion.plans.starter_tasks import TaskName

RIGHT = starter("first", StarterSpace.FIELD, TaskName.INSPECTION).mission
TASK = "  home: F G at(Home)"
MISTAKES = {  # what is replaced, by what, the line that is named, words of the answer
    "or": (TASK, "  home: F at(A) or F at(B)", "home:", "write |"),
    "AND": (TASK, "  home: F at(A) AND F at(B)", "home:", "write &"),
    "not": (TASK, "  home: G not at(B)", "home:", "write !"),
    "two equal signs": (TASK, "  home: at(A) == at(B)", "home:", "write <->"),
    "an arrow of programs": (TASK, "  home: G (at(A) => F at(B))", "home:", "write ->"),
    "an arrow of books": (TASK, "  home: G (at(A) → F at(B))", "home:", "write ->"),
    "a box": (TASK, "  home: □ at(Home)", "home:", "write G"),
    "a diamond": (TASK, "  home: ◇ at(Home)", "home:", "write F"),
    "a box of ASCII": (TASK, "  home: '[] at(Home)'", "home:", "write G"),
    "a diamond of ASCII": (TASK, "  home: '<> at(Home)'", "home:", "write F"),
    "a word for F": (TASK, "  home: eventually at(Home)", "home:", "write F"),
    "a word for G": (TASK, "  home: always at(Home)", "home:", "write G"),
    "operators glued": (TASK, "  home: GF at(Home)", "home:", "did you mean 'G F'?"),
    "a bracket too few": (TASK, "  home: F (at(Home)", "home:", "ends too early"),
    "a place misspelt": (TASK, "  home: F at(Hmoe)", "home:", "Did you mean at(Home)?"),
    "an unknown fact": (TASK, "  home: F landed", "home:", "unknown fact landed"),
    "a unit": ("speed_mps: 5", "speed_mps: 5 m/s", "speed_mps", "write the number alone: 5."),
    "a number in quotes": ("speed_mps: 5", "speed_mps: '5'", "speed_mps", "expected a number"),
    "a key misspelt": ("speed_mps: 5", "sped_mps: 5", "sped_mps", "Did you mean speed_mps?"),
    "no version": ("version: 1\n", "", None, "the key version is missing"),
    "a fence of two corners": (
        "[[-20, -20], [60, -20], [60, 50], [-20, 50]]",
        "[[-20, -20], [60, 50]]",
        "fence:",
        "expected at least 3 entries",
    ),
    "a place outside the fence": ("A: {east_m: 40", "A: {east_m: 400", "A:", "outside"),
    "a place without its height": (", up_m: 6}", "}", "Home:", "up_m"),
    "a tab": ("  speed_mps", "\tspeed_mps", "\tspeed_mps", "indent with spaces"),
    "a minus of books": (
        "[[-20, -20]",
        "[[\u221220, -20]",
        "fence:",
        "write the minus of the keyboard: -20.",
    ),
    "no space after a colon": (
        "  speed_mps: 5",
        "  speed_mps:5",
        "up_m:",
        "line 13 lacks a space after the colon: write speed_mps: 5",
    ),
    "a space that cannot be broken": (
        "  speed_mps",
        "\u00a0 speed_mps",
        "up_m:",
        "line 13 has a space that is none, U+00A0",
    ),
    "a brace that is not closed": (
        "north_m: 0, up_m: 6}",
        "north_m: 0, up_m: 6",
        "A:",
        "what is opened in line 19 is not closed",
    ),
    "a quote that is not closed": ("name: first", "name: 'first", "name:", "never closed"),
    "quotes of books": (TASK, "  home: \u201cF at(Home)\u201d", "home:", "is made of names"),
    "a pattern misspelt": (TASK, "  home: patroling(A, B)", "home:", "mean patrolling(A, B)?"),
    "a place without at": (TASK, "  home: F G Home", "home:", "Did you mean at(Home)?"),
    "a name of two words": ("  A: {", "  Site A: {", "Site A:", "no digit first: write Site_A"),
    "an unknown component": ("photo(camera)", "photo(kamera)", "execute:", "kamera"),
    "an unknown command": (
        "photo(camera)",
        "command(camera, MAV_CMD_TAKE_PHOTO)",
        "execute:",
        "MAV_CMD_TAKE_PHOTO",
    ),
}  # fmt: skip


@pytest.mark.parametrize("mistake", MISTAKES)
def test_the_answer_names_the_place_and_a_remedy(mistake: str, tmp_path: Path) -> None:
    right, wrong, place, words = MISTAKES[mistake]
    assert right in RIGHT
    text = RIGHT.replace(right, wrong, 1)
    path = tmp_path / "first.yaml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(MissionError) as error:
        load_mission(path)
    answer = str(error.value)
    assert words in answer
    assert answer.count("\n") >= 1, "a remedy"
    named = re.match(rf"{re.escape(str(path))}:(\d+):\d+: ", answer)
    assert named, answer
    if place is not None:
        assert place in text.splitlines()[int(named[1]) - 1]


def test_an_empty_file(tmp_path: Path) -> None:
    (tmp_path / "first.yaml").write_text("")
    with pytest.raises(MissionError, match="companion new NAME writes a mission"):
        load_mission(tmp_path / "first.yaml")


def test_all_that_is_wrong_with_the_keys_is_told_at_once(tmp_path: Path) -> None:
    text = RIGHT.replace("speed_mps: 5", "speed_mps: fast").replace("tries: 2", "trys: 2")
    text = text.replace("A: {east_m", "A: {east", 1).replace("version: 1\n", "")
    (tmp_path / "first.yaml").write_text(text)
    with pytest.raises(MissionError) as error:
        load_mission(tmp_path / "first.yaml")
    told = [line for line in str(error.value).splitlines() if line.startswith(str(tmp_path))]
    assert [re.sub(r"^.*?:\d+:\d+: ", "", line) for line in told] == [
        "unknown key 'east' in places.A",
        "unknown key 'trys' in skills.shoot",
        "the key version is missing",
        "speed_mps is 'fast', expected a number",
    ]


def test_many_mistakes_are_told_by_the_first_ones(tmp_path: Path) -> None:
    unknown = "".join(f"extra_{number}: 1\n" for number in range(50))
    (tmp_path / "first.yaml").write_text(RIGHT + unknown)
    with pytest.raises(MissionError) as error:
        load_mission(tmp_path / "first.yaml")
    assert str(error.value).count("unknown key") == 10


def test_lines_that_contradict_each_other_are_told_with_their_lines(
    companion: Companion, tmp_path: Path
) -> None:
    path = tmp_path / "first.yaml"
    path.write_text(RIGHT.replace(TASK, "  home: G at(Home)\n  out: F at(A)"), encoding="utf-8")
    lines = path.read_text(encoding="utf-8").splitlines()
    for command in ("check", "plan"):
        ended = companion(command, path)
        assert ended.code == 3
        told = re.findall(r"^  (\w+): .*  \(line (\d+)\)$", ended.err, re.MULTILINE)
        assert len(told) == 2
        assert all(lines[int(number) - 1].startswith(f"  {name}:") for name, number in told)
