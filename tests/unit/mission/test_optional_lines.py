"""Lines of a task that may be dropped: how they are written, and what is refused."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import pytest
from moves import MOVE

from companion import load_mission
from companion.errors import MissionError
from companion.ltl.parser import parse
from companion.mission.model import Mission


def room(task: Mapping[str, object] | None, **more: object) -> dict[str, Any]:
    places = {"Home": (0, 0), "A": (5, 0), "B": (5, 5)}
    return {
        "version": 1,
        "name": "room",
        "map": {"east_m": [-2, 12], "north_m": [-2, 12]},
        "limits": {
            "speed_mps": 2,
            "up_m": [0.5, 4],
            "fence": [[-1.5, -1.5], [11, -1.5], [11, 11], [-1.5, 11]],
        },
        "places": {
            name: {"east_m": east_m, "north_m": north_m, "up_m": 2}
            for name, (east_m, north_m) in places.items()
        },
        "sets": {"Place": list(places)},
        "skills": {"move": MOVE},
        "initially": ["at(Home)"],
        **({"task": task} if task is not None else {}),
        **more,
    }


def read(task: Mapping[str, object], **more: object) -> Mission:
    return load_mission(room(task, **more))


def refused(task: Mapping[str, object], **more: object) -> str:
    with pytest.raises(MissionError) as error:
        read(task, **more)
    return str(error.value)


def test_a_line_is_a_formula_or_a_mapping_of_it() -> None:
    line = {"formula": "G F at(B)", "priority": 2}
    mission = read({"a": "G F at(A)", "b": line, "c": {"formula": "F at(Home)"}})
    assert mission.task["b"] == parse("G F at(B)")
    assert mission.task["c"] == parse("F at(Home)")
    assert mission.priorities == {"b": 2}


def test_the_most_important_line_comes_first_and_ties_fall_to_the_file() -> None:
    ranks = {"u": 1, "v": 3, "w": 1, "x": 2, "y": 3}
    lines: dict[str, object] = {
        name: {"formula": "F at(B)", "priority": rank} for name, rank in ranks.items()
    }
    assert read({"a": "G F at(A)", **lines}).optional == ("v", "y", "x", "u", "w")


@pytest.mark.parametrize("priority", [0, -1, 1.5, "high", True, None])
def test_a_priority_is_a_positive_whole_number(priority: object) -> None:
    told = refused({"a": "F at(A)", "b": {"formula": "F at(B)", "priority": priority}})
    assert told.startswith("task.b.priority: ")


def test_one_line_at_least_is_never_dropped() -> None:
    only = {"b": {"formula": "F at(B)", "priority": 1}}
    assert "every line of the task may be dropped" in refused(only)
    assert read(only, goal="at(A)").optional == ("b",)
    assert read(only, tree=["move(Home, A)"]).optional == ("b",)


def test_a_mistake_in_a_formula_is_shown_at_its_place() -> None:
    told = refused({"a": "F at(A)", "b": {"formula": "F at(X)", "priority": 1}})
    assert told.splitlines()[0] == "task.b.formula: unknown fact at(X)"
    assert refused({"a": "F at(X)"}).splitlines()[0] == "task.a: unknown fact at(X)"


def test_an_event_may_restart_an_optional_line() -> None:
    event = {"when": "COMMAND.MAV_CMD_USER_1", "restarts": ["b"]}
    lines: dict[str, object] = {"a": "F at(A)", "b": {"formula": "F at(B)", "priority": 1}}
    assert read(lines, events={"asked": event}).events["asked"].restarts == {"b"}
