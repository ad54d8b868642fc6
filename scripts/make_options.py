"""Writes docs/options.md: every command with its arguments and options, as in `--help`.

Run it after a change of a command line; a test compares the page.

Usage: python scripts/make_options.py
"""

from __future__ import annotations

import inspect
import re
from collections.abc import Iterator
from enum import Enum, EnumType
from pathlib import Path
from typing import Any, get_args, get_type_hints

import typer
from typer.main import get_command

from companion.cli import app
from sitl.cli import simulate

PAGE = Path(__file__).parent.parent / "docs" / "options.md"
INTRODUCTION = """# Options

Every command with its arguments and options, as `--help` has them (`scripts/make_options.py`).
[commands.md](commands.md) says which command does what, and what exit codes mean.
"""
OF_ALL = {"--help", "--install-completion", "--show-completion"}
"""Options of every typer program."""


def commands() -> dict[str, Any]:
    """The public commands, by what the user types."""
    simulator = typer.Typer()
    simulator.command()(simulate)
    return dict(_public(get_command(app), "companion")) | {"sitl": get_command(simulator)}


def _public(command: Any, path: str) -> Iterator[tuple[str, Any]]:
    """A click command and those below it; groups themselves are left out."""
    inner = getattr(command, "commands", None)
    if inner is None:
        yield path, command
        return
    for name, each in inner.items():
        yield from () if each.hidden else _public(each, f"{path} {name}")


def page() -> str:
    """The page as generated."""
    return INTRODUCTION + "".join(_section(path, command) for path, command in commands().items())


def _section(path: str, command: Any) -> str:
    shown = [each for each in command.params if not getattr(each, "hidden", False)]
    shown = [each for each in shown if not OF_ALL & {*each.opts}]
    types = get_type_hints(inspect.unwrap(command.callback))
    rows = "".join(_row(each, types.get(each.name)) for each in shown)
    table = f"| option | default | what it does |\n|---|---|---|\n{rows}" if rows else ""
    return f"\n## {path}\n\n{_text(command.help)}\n\n{table}"


def _text(help_text: str) -> str:
    r"""The text of a command; a paragraph after \b keeps its lines."""
    paragraphs = re.sub(r"(?m)^ +$", "", help_text).strip().split("\n\n")
    return "\n\n".join(
        f"```text\n{paragraph.strip(chr(8)).strip(chr(10))}\n```"
        if "\b" in paragraph
        else paragraph
        for paragraph in paragraphs
    )


def _row(parameter: Any, type_: Any) -> str:
    cells = (_names(parameter, type_), _default(parameter), parameter.help or "")
    return f"| {' | '.join(cell.replace('|', chr(92) + '|') for cell in cells)} |\n"


def _names(parameter: Any, type_: Any) -> str:
    """What the user types, and the value after it."""
    if parameter.param_type_name == "argument":
        return f"`{parameter.metavar or parameter.name.upper()}`"
    kinds: list[Any] = [t for t in (type_, *get_args(type_)) if isinstance(t, EnumType)]
    value = parameter.metavar or "|".join(each.value for kind in kinds for each in kind)
    *others, last = parameter.opts
    return ", ".join(f"`{name}`" for name in [*others, f"{last} {value}".strip()])


def _default(parameter: Any) -> str:
    shown, default = parameter.show_default, parameter.default
    if parameter.required:
        return "required"
    if isinstance(shown, str):
        return shown
    is_none = default is None or default is False or default in ("", (), [])
    if is_none or not shown or callable(default):
        return ""
    return f"`{default.value if isinstance(default, Enum) else default}`"


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
    print(f"wrote {PAGE}")
