"""Every block of YAML in the documentation is what it looks like: a mission, a scenario, a part.

A whole mission is read and planned. Of a part, each key is held to the model that it belongs to, as
a file with it would be; a part of neither is some of a mission's skills. docs/how-to.md has none of
these: it is followed to the letter, like docs/tutorial.md.
"""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Annotated, Any

import pytest
from pydantic import BaseModel, TypeAdapter
from ruamel.yaml import YAML

from companion import Planner, load_mission
from companion.mission.schema import MissionFile
from companion.mission.skill_schema import SkillEntry
from sitl.world.schema import ScenarioModel

ROOT = Path(__file__).parents[1]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
BLOCKS = [
    pytest.param(block, id=f"{page.stem}-{number}")
    for page in PAGES
    if page.name != "how-to.md"
    for number, block in enumerate(
        re.findall(r"^```yaml\n(.*?)^```$", page.read_text(encoding="utf-8"), re.M | re.S)
    )
]


def check(model: type[BaseModel], content: dict[str, Any]) -> None:
    """Holds the values of some keys to a model."""
    for key, value in content.items():
        field = model.model_fields[key]
        type_: Any = field.annotation
        if field.metadata:
            type_ = Annotated[type_, *field.metadata]
        TypeAdapter(type_).validate_json(json.dumps(value), strict=True)


@pytest.mark.parametrize("block", BLOCKS)
def test_a_block_is_what_a_file_may_have(block: str) -> None:
    content = YAML(typ="safe").load(block)
    keys = set(content)
    if {"version", "places", "skills"} <= keys:
        assert Planner(load_mission(block)).plan().loop
    elif keys <= set(MissionFile.model_fields) and keys - {"version", "map", "vehicle"}:
        check(MissionFile, content)
    elif keys <= set(ScenarioModel.model_fields):
        check(ScenarioModel, content)
    else:
        for skill in content.values():
            check(SkillEntry, skill)


def test_blocks_are_found() -> None:
    assert len(BLOCKS) > 30
