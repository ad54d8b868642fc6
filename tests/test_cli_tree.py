"""`companion tree` as a user meets it: of a mission, of a run, in three formats."""

from __future__ import annotations

from pathlib import Path

import pytest
from commands import Companion

from companion import behaviour_tree, load_mission

MISSIONS = Path(__file__).parents[1] / "missions"
SURVEILLANCE, BY_HAND = MISSIONS / "surveillance.yaml", MISSIONS / "by_hand.yaml"


@pytest.mark.parametrize("format_", ["text", "dot", "xml"])
@pytest.mark.parametrize("mission", [SURVEILLANCE, pytest.param(BY_HAND, marks=pytest.mark.long)])
def test_the_tree_of_a_mission_is_that_of_the_api(
    companion: Companion, mission: Path, format_: str
) -> None:
    ended = companion("tree", mission, "--format", format_)
    assert (ended.code, ended.err) == (0, "")
    tree = behaviour_tree(load_mission(mission))
    texts = {"text": tree.to_text(), "dot": tree.to_dot(), "xml": tree.to_xml()}
    assert ended.out == texts[format_]


def test_the_tree_of_a_run_is_that_of_its_last_plan(
    companion: Companion, surveillance_run: Path
) -> None:
    ended = companion("tree", surveillance_run)
    assert ended.code == 0
    actions = [line.strip() for line in ended.out.splitlines() if line.strip().startswith("action")]
    assert actions == [
        *("action move(r1, r2)", "action upload(r2)", "action move(r2, Home)", "action wait"),
    ]
    assert ended.out == behaviour_tree(surveillance_run).to_text()


def test_what_is_wrong_is_told_with_its_exit_code(companion: Companion, tmp_path: Path) -> None:
    ended = companion("tree", tmp_path)
    assert ended.code == 2 and "is not a run folder" in ended.err
    ended = companion("tree", tmp_path / "missing.yaml")
    assert ended.code == 2 and "missing.yaml" in ended.err
    ended = companion("tree", SURVEILLANCE, "--format", "json")
    assert ended.code == 2
