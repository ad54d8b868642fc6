"""The diagrams of the documentation are those of the tables that the program runs by."""

from __future__ import annotations

import runpy
from enum import Enum
from pathlib import Path
from typing import Any

import pytest

from companion.transitions import StateTransition, TransitionTable

SCRIPT: dict[str, Any] = runpy.run_path(
    str(Path(__file__).parents[1] / "scripts" / "make_diagrams.py")
)
DIAGRAMS = {diagram.name: diagram.rows for diagram in SCRIPT["DIAGRAMS"]}


class Lamp(Enum):
    OFF = "off"
    ON = "very bright"
    BROKEN = "broken"


class Touch(Enum):
    MADE = "made"
    PRESSED = "pressed"
    KICKED = "kicked"
    DROPPED = "dropped"


TABLE = TransitionTable(
    StateTransition(None, Touch.MADE, Lamp.OFF, "it is dark"),
    StateTransition(Lamp.OFF, Touch.PRESSED, Lamp.ON, "it is bright"),
    StateTransition(Lamp.ON, Touch.KICKED, Lamp.BROKEN, "it is dark again"),
    StateTransition(Lamp.ON, Touch.DROPPED, Lamp.BROKEN, "it is dark again"),
)


def test_the_pages_are_current() -> None:
    """If this fails: python scripts/make_diagrams.py."""
    for page, text in SCRIPT["pages"]().items():
        assert page.read_text(encoding="utf-8") == text, page.name


def test_a_table_is_drawn_as_mermaid_and_as_rows() -> None:
    page = "before\n<!-- diagram: lamp -->\nold\n<!-- end of diagram: lamp -->\nafter\n"
    assert SCRIPT["drawn"](page, {"lamp": TABLE}).splitlines() == [
        "before",
        "<!-- diagram: lamp -->",
        "",
        "```mermaid",
        "stateDiagram-v2",
        "    very_bright: very bright",
        "    [*] --> off: made",
        "    off --> very_bright: pressed",
        "    very_bright --> broken: kicked<br/>dropped",
        "    broken --> [*]",
        "```",
        "",
        "| state | event | next state | what happens |",
        "|---|---|---|---|",
        "| none yet | made | off | it is dark |",
        "| off | pressed | very bright | it is bright |",
        "| very bright | kicked | broken | it is dark again |",
        "| very bright | dropped | broken | it is dark again |",
        "",
        "<!-- end of diagram: lamp -->",
        "after",
    ]


def test_a_table_without_a_row_for_its_beginning_begins_in_its_first_state() -> None:
    rows = [row for row in TABLE if row.state is not None]
    assert SCRIPT["mermaid"](rows).splitlines()[3:5] == [
        "    [*] --> off",
        "    off --> very_bright: pressed",
    ]


def test_the_arrows_of_a_long_table_have_the_numbers_of_its_lines() -> None:
    """Words would cover the picture; rows that differ in their state alone share a line."""
    rows = [StateTransition(Lamp.OFF, Touch.PRESSED, Lamp.ON, str(n)) for n in range(1, 22)]
    rows.append(StateTransition(Lamp.BROKEN, Touch.PRESSED, Lamp.ON, "21"))
    numbers = ", ".join(map(str, range(1, 22)))
    lines = SCRIPT["mermaid"](rows).splitlines()
    assert f"    off --> very_bright: {numbers}" in lines
    assert "    broken --> very_bright: 21" in lines
    page = "<!-- diagram: lamp -->\n<!-- end of diagram: lamp -->\n"
    told = SCRIPT["drawn"](page, {"lamp": rows})
    assert "| 20 | off | pressed |" in told and "| 21 | off, broken | pressed |" in told


def test_a_page_without_a_place_for_a_diagram_is_an_error() -> None:
    with pytest.raises(ValueError, match="not one place for the diagram lamp"):
        SCRIPT["drawn"]("no place\n", {"lamp": TABLE})


@pytest.mark.parametrize("name", DIAGRAMS)
def test_each_state_is_reached_from_the_beginning(name: str) -> None:
    rows = list(DIAGRAMS[name])
    state_kind: type[Enum] = type(rows[0].then)
    event_kind: type[Enum] = type(rows[0].event)
    states = set(state_kind)
    reached = {row.then for row in rows if row.state is None} or {rows[0].state}
    for _ in states:
        reached |= {row.then for row in rows if row.state in reached}
    assert reached == states
    assert {row.event for row in rows} == set(event_kind)


def test_an_event_that_cannot_occur_is_an_error_and_two_rows_for_one_too() -> None:
    assert TABLE.next(None, Touch.MADE) is Lamp.OFF
    assert TABLE.is_final(Lamp.BROKEN) and not TABLE.is_final(Lamp.OFF)
    with pytest.raises(ValueError, match="no transition from off on kicked"):
        TABLE.next(Lamp.OFF, Touch.KICKED)
    with pytest.raises(ValueError, match="same state and event"):
        TransitionTable(*TABLE, StateTransition(Lamp.OFF, Touch.PRESSED, Lamp.OFF, "twice"))
