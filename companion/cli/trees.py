"""The command that prints a plan's behaviour tree: tree."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from companion.cli.arguments import load
from companion.cli.log_lines import Verbose
from companion.cli.shipped import completions, mission_file


class TreeFormat(StrEnum):
    """Output formats of a behaviour tree."""

    TEXT = "text"
    DOT = "dot"
    XML = "xml"


Source = Annotated[
    Path,
    typer.Argument(
        metavar="MISSION|RUN",
        parser=mission_file,
        autocompletion=completions,
        help="The YAML file of a mission, the name of an example mission, or the folder of a run.",
    ),
]
FormatOption = Annotated[
    TreeFormat,
    typer.Option(
        "--format",
        help="text: a line for each node; dot: for Graphviz; xml: for BehaviorTree.CPP 4 and "
        "Groot2.",
    ),
]


def tree(source: Source, format_: FormatOption = TreeFormat.TEXT, verbose: Verbose = False) -> None:
    """Prints the behaviour tree of a plan.

    For a mission, this is the tree of its first plan, or the tree in the mission
    file. For a run, it is the tree that was ticked last.

    \b
    Examples:
      companion tree missions/surveillance.yaml
      companion tree missions/by_hand.yaml --format xml > by_hand.xml
      companion tree runs/2026-11-21T101500-surveillance --format dot | dot -Tsvg > tree.svg
    """
    from companion.api.trees import behaviour_tree

    made = behaviour_tree(source if source.is_dir() else load(source))
    write = {
        TreeFormat.TEXT: made.to_text,
        TreeFormat.DOT: made.to_dot,
        TreeFormat.XML: made.to_xml,
    }[format_]
    typer.echo(write(), nl=False)
