"""Draws the mission patterns into docs/patterns.md, with their pictures in docs/patterns/.

What the companion makes of an example is between two lines of the page, and is replaced as a whole:
the formula, the picture of its automata, a plan, and the picture of a flight of at most two laps.
The text around it is written by hand.

    <!-- pattern: past_avoidance(A, lit); with F at(A) & F at(B) -->
    <!-- end of pattern -->

`with` may add another line of the task, for a plan that shows more; `alarm at` gives the second of
the flight at which the alarm rises. Run it after a change of the page, or of translation, planning
or flying; tests compare the result.

Usage: python scripts/make_patterns.py
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import NamedTuple

import automaton_picture
import flight_picture

from companion import Mission, Planner, load_mission, simulate
from companion.ltl.conjuncts import conjuncts
from companion.ltl.parser import parse
from companion.ltl.patterns import PATTERNS
from companion.ltl.translate import translate

DOCS = Path(__file__).parent.parent / "docs"
PAGE = DOCS / "patterns.md"
PLACES = frozenset({"at(Home)", "at(A)", "at(B)"})
ALARM, LIGHT = "MAV_CMD_USER_1", "MAV_CMD_USER_2"
MISSION = {
    "version": 1,
    "name": "patterns",
    "limits": {
        "speed_mps": 4,
        "up_m": [1, 10],
        "fence": [[-20, -20], [60, -20], [60, 60], [-20, 60]],
    },
    "places": {
        "Home": {"east_m": 0, "north_m": 0, "up_m": 3},
        "A": {"east_m": 30, "north_m": 0, "up_m": 3},
        "B": {"east_m": 20, "north_m": 20, "up_m": 3},
    },
    "sets": {"Place": ["Home", "A", "B"]},
    "components": {"lamp": 25},
    "events": {"alarm": {"when": f"COMMAND.{ALARM}", "latch": True}},
    "skills": {
        "move": {
            "parameters": {"from": "Place", "to": "Place"},
            "precondition": "at(from)",
            "effect": "at(to) & !at(from)",
            "execute": "fly(to)",
        },
        "light": {
            "precondition": "!lit",
            "effect": "lit",
            "execute": f"command(lamp, {LIGHT})",
        },
    },
    "initially": ["at(Home)"],
}
"""The mission of the plans, which the page describes."""
WORLD = {
    "version": 1,
    "payload": {"component": 25, "command": LIGHT, "otherwise": "ACCEPTED"},
}
BLOCK = re.compile(
    r"(?<=^<!-- pattern: )(?P<example>[^;\n]+?)(; with (?P<also>[^;\n]+?))?"
    r"(; alarm at (?P<alarm_s>\d+) s)? -->\n(?P<made>.*?)(?=^<!-- end of pattern -->$)",
    re.MULTILINE | re.DOTALL,
)


class Example(NamedTuple):
    """A pattern with arguments, another line of the task, and when the alarm rises."""

    text: str
    also: str | None
    alarm_s: str | None

    @property
    def name(self) -> str:
        """The name of the pattern."""
        return self.text.partition("(")[0]

    @property
    def automata(self) -> Path:
        """The file with the picture of its automata."""
        return DOCS / "patterns" / f"{self.name}.svg"

    @property
    def flight(self) -> Path:
        """The file with the picture of a flight."""
        return DOCS / "patterns" / f"{self.name}_flight.svg"

    @property
    def mission(self) -> Mission:
        """The mission with the task of the example."""
        also = {"also": self.also} if self.also else {}
        return load_mission(MISSION | {"task": {"pattern": self.text} | also})


def examples(page: str) -> list[Example]:
    """The examples of a page."""
    return [Example(*found.group("example", "also", "alarm_s")) for found in BLOCK.finditer(page)]


def plan(example: Example) -> str:
    """The plan for an example, as a sentence."""
    beside = f", with `{example.also}` beside it" if example.also else ""
    before = f"`{Planner(example.mission).plan()}`"
    if not example.alarm_s:
        return f"A plan{beside}: {before}."
    after = f"`{Planner(example.mission).plan(facts={'alarm'})}`"
    return f"A plan{beside}: {before}; while `alarm` is true: {after}."


def made(example: Example) -> str:
    """The text between the lines of an example."""
    return (
        f"\n`{PATTERNS[example.name].signature}`; for example `{example.text}` is\n\n"
        f"```\n{parse(example.text)}\n```\n\n"
        f"![The automata of {example.text}](patterns/{example.automata.name})\n\n"
        f"{plan(example)}\n\n"
        f"![A flight of {example.text}](patterns/{example.flight.name})\n\n"
    )


def files(page: str) -> dict[Path, str]:
    """The page and the pictures of automata as generated."""

    def replaced(found: re.Match[str]) -> str:
        opening = found[0][: found.start("made") - found.start()]
        return opening + made(Example(*found.group("example", "also", "alarm_s")))

    pictures = {
        example.automata: automaton_picture.picture(
            [translate(part, exclusive=PLACES) for part in conjuncts(parse(example.text))]
        )
        for example in examples(page)
    }
    return {PAGE: BLOCK.sub(replaced, page)} | pictures


def flown(example: Example) -> str:
    """The picture of a flight of an example, as generated."""
    alarm = {"at_s": int(example.alarm_s), "operator": ALARM} if example.alarm_s else None
    world = WORLD | ({"happens": [alarm]} if alarm else {})
    flight = simulate(example.mission, world, laps=2)
    return flight_picture.picture(flight)


if __name__ == "__main__":
    page = PAGE.read_text(encoding="utf-8")
    flights = {example.flight: flown(example) for example in examples(page)}
    for path, text in (files(page) | flights).items():
        path.write_text(text, encoding="utf-8")
    print(f"wrote {PAGE} and its pictures")
