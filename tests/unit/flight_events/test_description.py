"""Schema and documentation of events.jsonl are those that scripts/make_schema.py generates."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from companion.flight_events.catalogue import EVENTS, RECORDED
from companion.flight_events.description import json_schema, kinds_table, with_tables
from companion.flight_events.event import FlightEvent
from companion.flight_events.event_fields import fields_of
from companion.flight_events.plans import PlannedAction
from companion.flight_events.tree import ActionTreeNode, TreeNode

ROOT = Path(__file__).parents[3]
PAGE = ROOT / "docs" / "run-folder.md"
PACKAGE = "companion.flight_events"


def test_the_checked_in_schema_is_the_generated_one() -> None:
    stored = (ROOT / "missions" / "events.schema.json").read_text(encoding="utf-8")
    assert stored == json.dumps(json_schema(), indent=2) + "\n"


def test_the_tables_of_the_documentation_are_the_generated_ones() -> None:
    page = PAGE.read_text(encoding="utf-8")
    assert kinds_table() in page
    assert with_tables(page) == page


def test_tables_are_made_anew_where_they_stand() -> None:
    page = PAGE.read_text(encoding="utf-8")
    assert with_tables(page.replace(kinds_table(), "| an old table |\n")) == page


@pytest.mark.parametrize("owner", [*EVENTS, PlannedAction, TreeNode, ActionTreeNode])
def test_every_class_and_every_key_is_described(owner: type) -> None:
    first = (owner.__doc__ or "").partition("\n")[0]
    assert first.endswith(".") and len(first) > 10
    assert [field.name for field in fields_of(owner) if not field.doc] == []


def test_every_recorded_class_is_in_the_schema_by_its_name() -> None:
    schema = json_schema()
    names = [event.__name__ for event in RECORDED]
    assert [each["$ref"] for each in schema["anyOf"]] == [f"#/$defs/{name}" for name in names]
    for event in RECORDED:
        about: dict[str, Any] = schema["$defs"][event.__name__]["properties"]
        assert about["type"] == {"const": event.__name__}
        assert about["kind"] == {"const": event.kind}
        fields = [field.name for field in fields_of(event)]
        assert list(about) == ["t_s", "type", "kind", "text", *fields]


def test_the_catalogue_is_complete() -> None:
    """Every class of the package with a template of its own is in it, once."""

    def below(owner: type[FlightEvent]) -> set[type[FlightEvent]]:
        return {owner}.union(*(below(each) for each in owner.__subclasses__()))

    ours = {each for each in below(FlightEvent) if each.__module__.startswith(PACKAGE)}
    names = sorted({each.__name__ for each in ours if hasattr(each, "template")})
    assert sorted(event.__name__ for event in EVENTS) == names
