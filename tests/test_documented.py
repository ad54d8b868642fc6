"""Whatever is public has its place in the documentation: commands, options, kinds of events.

Keys of files are held to their pages by test_reference.py, patterns by test_pattern_page.py.
"""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from make_options import PAGE, commands, page

from companion.flight_events.catalogue import RECORDED

DOCS = Path(__file__).parents[1] / "docs"
COMMANDS = list(commands())


@pytest.mark.parametrize("path", COMMANDS)
def test_a_command_is_in_the_table(path: str) -> None:
    page = (DOCS / "commands.md").read_text(encoding="utf-8")
    assert re.search(rf"^\|.*`{path}[ `].* \|", page, re.MULTILINE)


def test_the_page_of_options_is_current() -> None:
    """If this fails: python scripts/make_options.py."""
    assert PAGE.read_text(encoding="utf-8") == page()


@pytest.mark.parametrize("path", COMMANDS)
def test_a_help_text_fits_eighty_columns(path: str) -> None:
    """Lines of a terminal; the first paragraph is joined to one line, and broken where it ends."""
    _, *paragraphs = commands()[path].help.split("\n\n")
    lines = [line for each in paragraphs if "\b" not in each for line in each.splitlines()]
    assert not [line for line in lines if len(line) > 78]


@pytest.mark.parametrize("path", COMMANDS)
def test_a_help_text_has_no_brackets_that_rich_leaves_out(path: str) -> None:
    """What stands in [...] is markup to a terminal, and not shown."""
    command = commands()[path]
    texts = [command.help, *(each.help or "" for each in command.params)]
    assert not [text for text in texts if re.search(r"\[[a-z#/@]", text)]


def test_each_kind_of_event_is_in_the_table() -> None:
    page = (DOCS / "run-folder.md").read_text(encoding="utf-8")
    missing = [
        event.__name__ for event in RECORDED if f"| `{event.__name__}` | `{event.kind}`" not in page
    ]
    assert not missing
