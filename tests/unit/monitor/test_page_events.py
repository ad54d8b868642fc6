"""What the page knows of kinds of events: they exist, and which are no news it is told."""

from __future__ import annotations

import json
import re
from pathlib import Path

from companion.flight_events.catalogue import EVENTS, FOR_PROGRAMS
from companion.flight_events.sortie import Phase
from companion.monitor.follower import Follower
from companion.monitor.page_events import DERIVED
from companion.monitor.server import STATIC

KINDS = {event.kind for event in (*EVENTS, *DERIVED)}


def test_derived_events_have_kinds_of_their_own() -> None:
    assert len({event.kind for event in DERIVED}) == len(DERIVED)
    assert not {event.kind for event in DERIVED} & {event.kind for event in EVENTS}


def test_the_page_is_told_which_kinds_are_no_news(surveillance_run: Path) -> None:
    told = Follower(surveillance_run, is_live=False).mission["for_programs"]
    assert set(told) == FOR_PROGRAMS | {event.kind for event in DERIVED}


def test_the_kinds_that_the_page_draws_exist() -> None:
    drawn = set()
    for path in STATIC.glob("*.js"):
        text = path.read_text(encoding="utf-8")
        drawn |= set(re.findall(r'case "(\w+)"', text))
        drawn |= set(re.findall(r'kind [!=]== "(\w+)"', text))
        drawn |= set(re.findall(r"touched\.(\w+)", text))
        for listed in re.findall(r"new Set\(\[(.*?)\]\)", text, re.DOTALL):
            drawn |= set(re.findall(r'"([\w ]+)"', listed)) if path.stem == "event_list" else set()
    assert drawn >= {"tree", "replan", "withdrawn", "end"}
    assert drawn <= KINDS


def test_the_kinds_that_the_page_colours_exist() -> None:
    style = (STATIC / "style.css").read_text(encoding="utf-8")
    lines = [line for line in style.splitlines() if line.startswith("#lines")]
    coloured = set(re.findall(r'data-kind="(\w+)"', "".join(lines)))
    assert "violation" in coloured and coloured <= KINDS


def test_the_phases_that_the_page_knows_exist() -> None:
    text = (STATIC / "charge.js").read_text(encoding="utf-8")
    (listed,) = re.findall(r"OVER = new Set\((\[.*\])\)", text)
    assert set(json.loads(listed)) <= {phase.value for phase in Phase}
