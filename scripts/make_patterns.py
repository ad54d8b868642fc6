"""Draws the mission patterns into docs/patterns.md, with their automata in docs/patterns/.

What the companion makes of an example stands between two lines of the page, and is replaced as a
whole: the formula, a plan, and the picture of its automata. The words around it are the page's own.

    <!-- pattern: past_avoidance(A, lit); with F at(A) & F at(B) -->
    <!-- end of pattern -->

After `with` there may be another line of the task, for a plan that shows more, and after `while` an
event that is true. Run it after a change of the page, or of translation or planning; a test
compares.

Usage: python scripts/make_patterns.py
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import NamedTuple

from automaton_picture import picture

from companion import NoPlan, Planner, load_mission
from companion.ltl.formula import conjuncts
from companion.ltl.parser import parse
from companion.ltl.patterns import PATTERNS
from companion.ltl.translate import translate

DOCS = Path(__file__).parent.parent / "docs"
PAGE = DOCS / "patterns.md"
PLACES = frozenset({"at(Home)", "at(A)", "at(B)"})
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
    "events": {"alarm": {"when": "COMMAND.MAV_CMD_USER_1"}},
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
            "execute": "command(lamp, MAV_CMD_USER_1)",
        },
    },
    "initially": ["at(Home)"],
}
"""The mission of the plans, which the page describes."""
BLOCK = re.compile(
    r"(?<=^<!-- pattern: )(?P<example>[^;\n]+?)(; with (?P<also>[^;\n]+?))?"
    r"(; while (?P<event>\w+))? -->\n(?P<made>.*?)(?=^<!-- end of pattern -->$)",
    re.MULTILINE | re.DOTALL,
)


class Example(NamedTuple):
    """A pattern with arguments, another line of the task, and an event that is true."""

    text: str
    also: str | None
    event: str | None

    @property
    def name(self) -> str:
        """The name of the pattern."""
        return self.text.partition("(")[0]

    @property
    def picture(self) -> Path:
        """The file with its automata."""
        return DOCS / "patterns" / f"{self.name}.svg"


def examples(page: str) -> list[Example]:
    """The examples of a page."""
    return [Example(*found.group("example", "also", "event")) for found in BLOCK.finditer(page)]


def plan(example: Example) -> str:
    """What the planner makes of an example, as a sentence."""
    task = {"pattern": example.text} | ({"also": example.also} if example.also else {})
    conditions = [f"with `{example.also}` beside it"] if example.also else []
    conditions += [f"while `{example.event}` is true"] if example.event else []
    facts = {example.event} if example.event else set()
    try:
        found = f"`{Planner(load_mission(MISSION | {'task': task})).plan(facts=facts)}`"
    except NoPlan:
        found = "none"
    return f"{', '.join(['A plan', *conditions])}: {found}."


def made(example: Example) -> str:
    """What stands between the lines of an example."""
    return (
        f"\n`{PATTERNS[example.name].signature}`; for example `{example.text}` is\n\n"
        f"```\n{parse(example.text)}\n```\n\n"
        f"![The automata of {example.text}](patterns/{example.name}.svg)\n\n{plan(example)}\n\n"
    )


def files(page: str) -> dict[Path, str]:
    """The page and its pictures as they should be."""

    def replaced(found: re.Match[str]) -> str:
        opening = found[0][: found.start("made") - found.start()]
        return opening + made(Example(*found.group("example", "also", "event")))

    pictures = {
        example.picture: picture(
            [translate(part, exclusive=PLACES) for part in conjuncts(parse(example.text))]
        )
        for example in examples(page)
    }
    return {PAGE: BLOCK.sub(replaced, page)} | pictures


if __name__ == "__main__":
    for path, text in files(PAGE.read_text(encoding="utf-8")).items():
        path.write_text(text, encoding="utf-8")
    print(f"wrote {PAGE} and its pictures")
