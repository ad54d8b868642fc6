"""The files that are checked in agree with the code that made or reads them."""

from __future__ import annotations

import json
from pathlib import Path

from companion.ltl.parser import parse
from companion.mission.loader import load_mission
from companion.mission.schema import json_schema

MISSIONS = Path(__file__).parents[3] / "missions"


def test_checked_in_schema_is_the_generated_one() -> None:
    """If this fails: python scripts/make_schema.py."""
    assert json.loads((MISSIONS / "mission.schema.json").read_text()) == json_schema()


def test_every_key_of_the_schema_is_described() -> None:
    schema = json_schema()
    entries = [schema, *schema["$defs"].values()]
    undescribed = [
        name
        for entry in entries
        for name, field in entry.get("properties", {}).items()
        if not field.get("description")
    ]
    assert undescribed == []


def test_a_mission_is_the_papers() -> None:
    """Section V: the places, the two action templates and the three conjuncts."""
    mission = load_mission(MISSIONS / "paper_section_v.yaml")
    assert mission.task == {
        "search": parse(
            "G ((F at(A) | targetFound) & (F at(B) | targetFound) & (F at(C) | targetFound))"
        ),
        "upload": parse("G ((targetFound | targetReported) -> F targetReported)"),
        "return": parse("G (targetReported -> X at(Home))"),
    }
    assert list(mission.places) == ["Home", "A", "B", "C", "r1", "r2", "r3"]
    assert list(mission.skills) == ["move", "upload"]
    assert mission.initially == {"at(Home)"}
    assert mission.events["targetFound"].latch
    assert mission.events["targetFound"].restarts == {"search"}


def test_editors_find_the_schema() -> None:
    first = (MISSIONS / "surveillance.yaml").read_text().splitlines()[0]
    assert first == "# yaml-language-server: $schema=mission.schema.json"
