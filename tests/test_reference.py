"""docs/mission-keys.md and docs/scenario-keys.md: every key of every model, as it is."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, Any, get_args

import pytest
from make_reference import MISSION_PAGE, SCENARIO_PAGE, pages
from pydantic import BaseModel, TypeAdapter
from ruamel.yaml import YAML

from companion.mission.schema import MissionFile
from companion.vehicle_files import VehicleFile
from sitl.world.schema import ScenarioModel

DOCS = Path(__file__).parents[1] / "docs"
PAGES = {name: (DOCS / name).read_text(encoding="utf-8") for name in (MISSION_PAGE, SCENARIO_PAGE)}
ROOTS: dict[type[BaseModel], str] = {
    MissionFile: MISSION_PAGE,
    VehicleFile: MISSION_PAGE,
    ScenarioModel: SCENARIO_PAGE,
}


def models(root: type[BaseModel]) -> dict[type[BaseModel], None]:
    """A model, and all that its keys may have."""
    found = {root: None}
    waiting = [root]
    while waiting:
        for field in waiting.pop().model_fields.values():
            for model in inside(field.annotation):
                if model not in found:
                    found[model] = None
                    waiting.append(model)
    return found


def inside(type_: Any) -> Iterator[type[BaseModel]]:
    """The models in a type."""
    if isinstance(type_, type) and issubclass(type_, BaseModel):
        yield type_
    for argument in get_args(type_):
        yield from inside(argument)


def table(root: type[BaseModel], model: type[BaseModel]) -> dict[str, list[str]]:
    """The cells of the table of a model, by key: on its root's page, or on that of missions."""
    summary = f"\n{(model.__doc__ or '').partition(chr(10))[0]}"
    text = next(PAGES[p] for p in (ROOTS[root], MISSION_PAGE) if summary in PAGES[p])
    lines = text.partition(summary)[2].partition("\n#")[0].splitlines()
    rows = [re.split(r"(?<!\\) \| ", line[2:-2]) for line in lines if line.startswith("| `")]
    return {key.strip("`"): [key, *cells] for key, *cells in rows}


def test_the_pages_are_current() -> None:
    """If this fails: python scripts/make_reference.py."""
    made = pages()
    assert made.keys() == {DOCS / name for name in PAGES}
    for page, text in made.items():
        assert page.read_text(encoding="utf-8") == text, page.name


MODELS = pytest.mark.parametrize(
    ("root", "model"),
    [pytest.param(root, model, id=model.__name__) for root in ROOTS for model in models(root)],
)


@MODELS
def test_each_key_has_its_row(root: type[BaseModel], model: type[BaseModel]) -> None:
    assert list(table(root, model)) == list(model.model_fields)


@MODELS
def test_a_row_says_what_its_key_is(root: type[BaseModel], model: type[BaseModel]) -> None:
    """With an example that may stand there."""
    for key, cells in table(root, model).items():
        _, value, _, _, description, example = cells
        assert value and len(description) > 3 and example, key
        if example.startswith("`"):
            content = YAML(typ="safe").load(example.strip("`").replace("\\|", "|"))
            field = model.model_fields[key]
            type_: Any = field.annotation
            if field.metadata:
                type_ = Annotated[type_, *field.metadata]
            TypeAdapter(type_).validate_json(json.dumps(content), strict=True)
        else:
            assert re.fullmatch(r"\[its keys\]\((mission-keys\.md)?#\w+\)", example), key
