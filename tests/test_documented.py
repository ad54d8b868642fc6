"""Whatever is public has its place in the documentation: commands, options, kinds of events.

Keys of files are held to their pages by test_reference.py, patterns by test_pattern_page.py.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import typer
from typer.main import get_command

from companion.cli import app as companion_app
from companion.flight_events.catalogue import RECORDED
from sitl.cli import simulate

DOCS = Path(__file__).parents[1] / "docs"
COMMANDS_PAGE = (DOCS / "commands.md").read_text(encoding="utf-8")
TEXT = "".join(page.read_text(encoding="utf-8") for page in sorted(DOCS.glob("*.md")))


def public(command: Any, path: str) -> Iterator[tuple[str, Any]]:
    """A command of click and those below it, by what one types; groups are none themselves."""
    inner = getattr(command, "commands", None)
    if inner is None:
        yield path, command
        return
    for name, each in inner.items():
        yield from () if each.hidden else public(each, f"{path} {name}")


OF_TYPER = {"--help", "--install-completion", "--show-completion"}
COMMANDS = dict(public(get_command(companion_app), "companion"))
SIMULATOR = typer.Typer()
SIMULATOR.command()(simulate)
COMMANDS["sitl"] = get_command(SIMULATOR)


@pytest.mark.parametrize("path", COMMANDS)
def test_a_command_is_in_the_table(path: str) -> None:
    assert f"`{path} " in COMMANDS_PAGE


@pytest.mark.parametrize("path", COMMANDS)
def test_an_option_is_told_of(path: str) -> None:
    options = [each for each in COMMANDS[path].params if each.param_type_name == "option"]
    spelled = [each.opts for each in options if not each.hidden]
    missing = [names for names in spelled if not any(name in TEXT for name in names)]
    missing = [names for names in missing if not OF_TYPER & {*names}]
    assert not missing


def test_each_kind_of_event_is_in_the_table() -> None:
    page = (DOCS / "run-folder.md").read_text(encoding="utf-8")
    missing = [
        event.__name__ for event in RECORDED if f"| `{event.kind}` | `{event.__name__}`" not in page
    ]
    assert not missing
