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
from companion.flight_events.event_fields import keys_of
from companion.flight_events.plans import (
    NoPlanFound,
    PlanMade,
    PlannedAction,
    PlannedLasso,
    PlanReplaced,
    WrittenTreeAdopted,
)
from companion.flight_events.reading import read_line
from companion.flight_events.skills import PlaceReached, SkillFailed
from companion.flight_events.sortie import (
    AutopilotSaid,
    BatteryCharged,
    ChargeAwaited,
    ChargeCutShort,
    ChargeSufficient,
    GoalFailed,
    Phase,
    PhaseEntered,
    RunFailed,
    TaskSatisfied,
)
from companion.flight_events.tree import ActionTreeNode, NodeType, TreeBuilt, TreeNode
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
    """The line is; an event of a class that shares its kind may have the very same line."""
    stamped = Stamped(data.draw(TIMES), data.draw(events_of(kind)))
    line = line_of(stamped)
    read = read_line(json.dumps(line))
    assert line_of(read) == json.loads(json.dumps(line))
    assert read == stamped or read.event.kind == kind.kind
    assert is_valid(json.loads(json.dumps(line)), SCHEMA, SCHEMA)


def test_a_shipped_flight_is_read_back_and_valid(surveillance_run: Path) -> None:
    text = (surveillance_run / "events.jsonl").read_text(encoding="utf-8")
    for line in text.splitlines():
        assert json.dumps(line_of(read_line(line))) == line
        assert is_valid(json.loads(line), SCHEMA, SCHEMA), line


def test_keys_stand_in_the_order_of_the_fields() -> None:
    wait = PlannedAction("wait", "wait", (), 0.1)
    event = PlanReplaced(1, "denied", PlannedLasso((), (wait,), 0.0, 0.1))
    assert written(event) == (
        '{"t_s": 1.25, "kind": "replan", "text": "replan 1: denied -> (wait)^w", '
        '"number": 1, "reason": "denied", "prefix": [], '
        '"loop": [{"action": "wait", "skill": "wait", "arguments": [], "cost_s": 0.1}], '
        '"prefix_cost_s": 0.0, "lap_cost_s": 0.1, "dropped": []}'
    )


@pytest.mark.parametrize(
    "event",
    [
        PlanMade({"visit": "F at(A)"}, PlannedLasso((), (), 0.0, 0.0)),
        WrittenTreeAdopted({"visit": "F at(A)"}),
        NoPlanFound(12, "upload(r1) failed: denied: again", "no plan:\n  task: F at(A)"),
        PlaceReached("A", "inspect(Home, A)"),
        SkillFailed("upload(r1)", "denied: it failed: why"),
        PhaseEntered(Phase.TAKE_OFF),
        BatteryCharged(90),
        ChargeAwaited(22, patience_s=900),
        ChargeCutShort(41),
        ChargeSufficient(88, enough=85),
        AutopilotSaid("Low battery"),
        GoalFailed("not armed: denied"),
        TaskSatisfied(),
        RunFailed("task satisfied, landed", exit_code=3),
        TreeBuilt(
            (
                TreeNode(0, NodeType.SEQUENCE, "root"),
                ActionTreeNode(1, NodeType.ACTION, "wait", None, ()),
            )
        ),
    ],
    ids=lambda event: type(event).__name__,
)
def test_classes_that_share_a_kind_are_told_apart(event: FlightEvent) -> None:
    assert read_line(written(event)).event == event


def test_a_text_that_no_template_has_made_is_of_the_class_that_takes_any() -> None:
    line = '{"t_s": 1, "kind": "phase", "text": "charged to 007 %"}'
    assert read_line(line) == Stamped(1.0, GoalFailed("charged to 007 %"))


REACHED: dict[str, Any] = line_of(Stamped(1.25, PlaceReached("A", "move(Home, A)")))
TREE: dict[str, Any] = line_of(Stamped(0.0, TreeBuilt((TreeNode(0, NodeType.LEAF, "rest"),))))
MADE: dict[str, Any] = line_of(
    Stamped(0.0, PlanMade({"visit": "F at(A)"}, PlannedLasso((), (), 0.0, 0.0)))
)


@pytest.mark.parametrize(
    ("line", "message"),
    [
        (REACHED | {"t_s": -1.0}, "t_s is missing here, or no time"),
        (REACHED | {"t_s": True}, "t_s is missing here, or no time"),
        (REACHED | {"t_s": "1"}, "t_s is missing here, or no time"),
        (REACHED | {"kind": 3}, "kind is missing here"),
        (REACHED | {"kind": "reached"}, "reached is no kind of event"),
        (REACHED | {"kind": "record"}, "record is no kind of event"),
        (REACHED | {"text": None}, "text is missing here"),
        (REACHED | {"text": "there"}, 'the text is not "at {place}"'),
        (REACHED | {"action": 1}, "action is missing here, or not of its kind"),
        (REACHED | {"place": "A"}, "place has no place here"),
        ({k: v for k, v in REACHED.items() if k != "action"}, "action is missing here"),
        (TREE | {"nodes": {}}, "nodes is missing here, or not of its kind"),
        (TREE | {"nodes": [7]}, "nodes is missing here, or not of its kind"),
        (TREE | {"nodes": [TREE["nodes"][0] | {"depth": True}]}, "nodes is missing here"),
        (TREE | {"nodes": [TREE["nodes"][0] | {"type": "bush"}]}, "nodes is missing here"),
        (TREE | {"nodes": [TREE["nodes"][0] | {"type": []}]}, "nodes is missing here"),
        (TREE | {"nodes": [TREE["nodes"][0] | {"leaves": 1}]}, "nodes is missing here"),
        (MADE | {"number": 1}, "number is not 0 here"),
        (MADE | {"task": ["F at(A)"]}, "task is missing here"),
        (MADE | {"lap_cost_s": float("nan")}, "lap_cost_s is missing here"),
        (MADE | {"lap_cost_s": True}, "lap_cost_s is missing here"),
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
    key = data.draw(
        st.sampled_from(["t_s", "kind", "text", *(f.name for f in keys_of(type(event)))])
    )
    del line[key]
    if line.keys() == {"t_s", "kind", "text", "number", "task"}:
        return  # what is left of a plan is a tree of the mission's own
    with pytest.raises(MissionError):
        read_line(json.dumps(line))
    assert not is_valid(json.loads(json.dumps(line)), SCHEMA, SCHEMA)


def test_a_key_has_one_place_among_the_classes_of_its_kind() -> None:
    """So a line's keys decide its class, or its text does among classes with the same keys."""
    for kind in RECORDED:
        names = [field.name for field in keys_of(kind)]
        assert len(names) == len(set(names)), kind
        assert not {"t_s", "kind", "text"} & set(names), kind


def test_kinds_that_are_not_told_share_no_kind_with_those_that_are() -> None:
    assert {event.kind for event in EVENTS if event.is_told}.isdisjoint(FOR_PROGRAMS)
    assert FOR_PROGRAMS == {"position", "task", "tree", "status", "battery", "charge"}
