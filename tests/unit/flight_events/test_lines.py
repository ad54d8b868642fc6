"""Lines of events.jsonl: what was written is read back, and nothing else."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from drawn import drawn
from hypothesis import given
from hypothesis import strategies as st
from json_schema import is_valid
from made_events import events_of

from companion.errors import Location, MissionError
from companion.flight_events.catalogue import EVENTS, FOR_PROGRAMS, RECORDED
from companion.flight_events.description import json_schema
from companion.flight_events.event import FlightEvent, Stamped
from companion.flight_events.event_fields import fields_of
from companion.flight_events.plans import (
    PlanMade,
    PlannedAction,
    PlannedLasso,
    PlanReplaced,
)
from companion.flight_events.reading import read_line
from companion.flight_events.skills import PlaceReached
from companion.flight_events.tree import NodeType, TreeBuilt, TreeNode
from companion.flight_events.writing import line_of

SCHEMA = json_schema()
TIMES = st.floats(0.0, 1e6, allow_nan=False)


def written(event: FlightEvent, time_s: float = 1.25) -> str:
    return json.dumps(line_of(Stamped(time_s, event)))


@pytest.mark.slow
@pytest.mark.parametrize("kind", RECORDED, ids=lambda kind: kind.__name__)
@drawn(25)
@given(st.data())
def test_what_was_written_is_read_back(kind: type[FlightEvent], data: st.DataObject) -> None:
    stamped = Stamped(data.draw(TIMES), data.draw(events_of(kind)))
    line = json.dumps(line_of(stamped))
    assert read_line(line) == stamped
    assert is_valid(json.loads(line), SCHEMA, SCHEMA)


def test_a_shipped_flight_is_read_back_and_valid(surveillance_run: Path) -> None:
    text = (surveillance_run / "events.jsonl").read_text(encoding="utf-8")
    for line in text.splitlines():
        assert json.dumps(line_of(read_line(line))) == line
        assert is_valid(json.loads(line), SCHEMA, SCHEMA), line


def test_keys_stand_in_the_order_of_the_fields() -> None:
    wait = PlannedAction("wait", "wait", (), 0.1)
    event = PlanReplaced(1, "denied", PlannedLasso((), (wait,), 0.0, 0.1))
    assert written(event) == (
        '{"t_s": 1.25, "type": "PlanReplaced", "kind": "replan", '
        '"text": "replan 1: denied -> (wait)^w", "number": 1, "reason": "denied", '
        '"plan": {"prefix": [], '
        '"loop": [{"action": "wait", "skill": "wait", "arguments": [], "cost_s": 0.1}], '
        '"prefix_cost_s": 0.0, "lap_cost_s": 0.1}, "dropped": []}'
    )


def test_what_people_read_is_not_read_by_programs() -> None:
    reached = PlaceReached("A", "move(Home, A)")
    reworded = line_of(Stamped(1.25, reached)) | {"kind": "arrived", "text": "has come to A"}
    assert read_line(json.dumps(reworded)) == Stamped(1.25, reached)


REACHED: dict[str, Any] = line_of(Stamped(1.25, PlaceReached("A", "move(Home, A)")))
TREE: dict[str, Any] = line_of(Stamped(0.0, TreeBuilt((TreeNode(0, NodeType.LEAF, "rest"),))))
MADE: dict[str, Any] = line_of(
    Stamped(0.0, PlanMade({"visit": "F at(A)"}, PlannedLasso((), (), 0.0, 0.0)))
)


PLAN: dict[str, Any] = MADE["plan"]


@pytest.mark.parametrize(
    ("line", "message"),
    [
        (REACHED | {"t_s": -1.0}, "t_s is not a time"),
        (REACHED | {"t_s": True}, "t_s is not a time"),
        (REACHED | {"t_s": "1"}, "t_s is not a time"),
        (REACHED | {"type": 3}, "3 is not a type of event"),
        (REACHED | {"type": []}, "[] is not a type of event"),
        (REACHED | {"type": "Reached"}, "Reached is not a type of event"),
        (REACHED | {"type": "RecordingFailed"}, "RecordingFailed is not a type of event"),
        (REACHED | {"action": 1}, "action is not of its type here"),
        (REACHED | {"up_m": 2.0}, "up_m has no place here"),
        ({k: v for k, v in REACHED.items() if k != "action"}, "action is missing here"),
        (TREE | {"nodes": {}}, "nodes is not of its type here"),
        (TREE | {"nodes": [7]}, "nodes is not of its type here"),
        (TREE | {"nodes": [TREE["nodes"][0] | {"depth": True}]}, "nodes is not of its type here"),
        (TREE | {"nodes": [TREE["nodes"][0] | {"type": "bush"}]}, "nodes is not of its type here"),
        (TREE | {"nodes": [TREE["nodes"][0] | {"type": []}]}, "nodes is not of its type here"),
        (TREE | {"nodes": [TREE["nodes"][0] | {"leaves": 1}]}, "nodes is not of its type here"),
        (MADE | {"number": 1}, "number is not of its type here"),
        (MADE | {"number": False}, "number is not of its type here"),
        (MADE | {"task": ["F at(A)"]}, "task is not of its type here"),
        (MADE | {"plan": PLAN | {"lap_cost_s": float("nan")}}, "plan is not of its type here"),
        (MADE | {"plan": PLAN | {"lap_cost_s": True}}, "plan is not of its type here"),
        (MADE | {"plan": None}, "plan is not of its type here"),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_a_line_that_is_not_as_documented_is_refused(line: dict[str, Any], message: str) -> None:
    with pytest.raises(MissionError, match=r"^events\.jsonl:7:1: ") as caught:
        read_line(json.dumps(line), Location("events.jsonl", 7, 1))
    assert message in str(caught.value)


@pytest.mark.parametrize("line", ["", "{", "[1]", "7", "[" * 100_000])
def test_what_is_no_object_is_refused(line: str) -> None:
    with pytest.raises(MissionError, match="this line is not"):
        read_line(line)


@given(st.sampled_from(RECORDED).flatmap(events_of), st.data())
def test_a_line_without_one_of_its_keys_is_neither_read_nor_valid(
    event: FlightEvent, data: st.DataObject
) -> None:
    line = line_of(Stamped(1.25, event))
    del line[data.draw(st.sampled_from(sorted(line)))]
    with pytest.raises(MissionError):
        read_line(json.dumps(line))
    assert not is_valid(json.loads(json.dumps(line)), SCHEMA, SCHEMA)


def test_no_field_has_the_name_of_a_key_of_every_line() -> None:
    for event in RECORDED:
        names = {field.name for field in fields_of(event)}
        assert not {"t_s", "type", "kind", "text"} & names, event


def test_kinds_that_are_not_told_share_no_kind_with_those_that_are() -> None:
    assert {event.kind for event in EVENTS if event.is_told}.isdisjoint(FOR_PROGRAMS)
    assert FOR_PROGRAMS == {"position", "task", "tree", "status", "battery", "charge"}
