"""Writes the table of hazards in docs/SAFETY.md, from docs/hazards.toml.

Each hazard is a row: what is promised, the tests that show it, and what is not promised. The rest
of the page is written by hand. Run it after a change of docs/hazards.toml. A test compares the two,
and checks that each named test exists.

Usage: python scripts/make_safety.py
"""

from __future__ import annotations

import re
import tomllib
from pathlib import Path
from typing import NamedTuple

DOCS = Path(__file__).parent.parent / "docs"
PAGE, HAZARDS = DOCS / "SAFETY.md", DOCS / "hazards.toml"
BEGIN, END = "<!-- generated: hazards -->", "<!-- end of generated: hazards -->"
HEAD = "| # | hazard | what is promised | tests | what is not promised |\n|---|---|---|---|---|"


class Hazard(NamedTuple):
    """Something that may go wrong.

    Attributes:
        number: in the catalogue.
        hazard: what happens.
        promise: what the companion does then.
        tests: those that show it, as FILE::FUNCTION below tests/.
        outside: what is not promised; may be empty.
    """

    number: int
    hazard: str
    promise: str
    tests: list[str]
    outside: str = ""

    def row(self) -> str:
        """As a line of a table."""
        shown = ", ".join(_linked(test) for test in self.tests)
        return f"| {self.number} | {self.hazard} | {self.promise} | {shown} | {self.outside} |"


def catalogue() -> dict[str, list[Hazard]]:
    """The hazards by the title of their group.

    Raises:
        TypeError: one has too many keys, or too few.
    """
    groups = tomllib.loads(HAZARDS.read_text(encoding="utf-8"))["group"]
    return {group["title"]: [Hazard(**entry) for entry in group["hazard"]] for group in groups}


def page(text: str, groups: dict[str, list[Hazard]]) -> str:
    """The page with its tables regenerated.

    Args:
        text: the text of the page.
        groups: the hazards by title.

    Raises:
        ValueError: the page does not have exactly one place for them.
    """
    place = re.compile(f"{re.escape(BEGIN)}\n.*?{re.escape(END)}", re.DOTALL)
    if len(place.findall(text)) != 1:
        raise ValueError("the page has not one place for the hazards")
    tables = [
        "\n".join([f"### {title}\n", HEAD, *(hazard.row() for hazard in hazards)])
        for title, hazards in groups.items()
    ]
    return place.sub(lambda _: "\n\n".join([BEGIN, *tables, END]), text)


def _linked(test: str) -> str:
    """A test with its readable name and a link to its file."""
    file, function = test.split("::")
    words = function.removeprefix("test_").replace("_", " ")
    return f"[{words}](../tests/{file})"


if __name__ == "__main__":
    PAGE.write_text(page(PAGE.read_text(encoding="utf-8"), catalogue()), encoding="utf-8")
    print(f"wrote the hazards of {PAGE}")
