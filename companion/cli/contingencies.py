"""Prints and draws `--contingencies`: a table, or its summary before a flight."""

from __future__ import annotations

import sys
from pathlib import Path

import typer
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn
from rich.table import Table

from companion.acting.contingencies.answers import ContingencyVerdict
from companion.acting.contingencies.fold_words import (
    answers_in_words,
    labels_in_words,
    positions_in_words,
)
from companion.acting.contingencies.table import ContingencyTable
from companion.api.contingency_answers import contingencies
from companion.errors import CompanionError
from companion.mission.loader import load_mission

UNSAFE = 8
"""The exit code if a flight would not have the charge to reach a safe place."""
WIDTH = 120
"""Width of a table that is not printed on a terminal."""
KINDS = {
    "event": "events",
    "event, then": "failures after events",
    "belief": "beliefs",
    "charger": "chargers",
    "site": "places",
    "drain": "energy",
    "charge": "energy",
}


def asked_table(mission: Path, jobs: int | None) -> ContingencyTable:
    """The table of a mission, with a progress bar on standard error.

    Raises:
        CompanionError: there is no table; or Ctrl-C has ended it.
    """
    bar = Progress(
        TextColumn("contingencies"),
        BarColumn(),
        MofNCompleteColumn(),
        TimeElapsedColumn(),
        console=Console(stderr=True),
        transient=True,
        disable=not sys.stderr.isatty(),
    )
    with bar:
        task = bar.add_task("contingencies", total=None)
        try:
            return contingencies(
                load_mission(mission),
                jobs,
                lambda done, total: bar.update(task, completed=done, total=total),
            )
        except KeyboardInterrupt:
            raise CompanionError(
                "stopped: no table of contingencies was made, and nothing of it is kept"
            ) from None


def sum_up(mission: Path) -> None:
    """Prints the summary of a mission before its flight.

    Raises:
        CompanionError: there is no table; or Ctrl-C has ended it.
        typer.Exit: a contingency is unsafe.
    """
    table = asked_table(mission, None)
    typer.echo(f"otherwise  {table.summary}")
    if table.unsafe:
        typer.echo(
            f"not flown: the charge does not last to a safe place in {len(table.unsafe)} of them\n"
            f"    companion check --contingencies {mission} shows them",
            err=True,
        )
        raise typer.Exit(UNSAFE)


def print_table(table: ContingencyTable) -> None:
    """Prints the positions, and the contingencies, grouped by equal answers."""
    console = Console(
        width=None if sys.stdout.isatty() else WIDTH, highlight=False, soft_wrap=False
    )
    places = Table("position", "at", "next", *(["charge"] if _has_charge(table) else []), box=None)
    for each in table.positions:
        charge = [] if each.charge_percent is None else [f"{each.charge_percent:.0f} %"]
        loop = " (loop)" if each.is_in_loop else ""
        places.add_row(str(each.number), each.place, each.ahead + loop, *charge)
    console.print(places)
    answers = Table("", "what turns out otherwise", "positions", "what the flight does")
    kind = ""
    for fold in table.folded():
        if kind and KINDS[fold.kind] != kind:
            answers.add_section()
        kind = KINDS[fold.kind]
        answers.add_row(
            fold.answers[0].verdict.letter,
            labels_in_words(fold),
            positions_in_words(fold.positions),
            answers_in_words(fold),
        )
    console.print(answers, markup=False)
    legend = ", ".join(f"{each.letter} {each.words}" for each in ContingencyVerdict)
    console.print(legend, markup=False)
    typer.echo(table.summary)


def _has_charge(table: ContingencyTable) -> bool:
    return any(position.charge_percent is not None for position in table.positions)


def draw_table(table: ContingencyTable, path: Path) -> None:
    """Draws a table to a PNG file.

    Raises:
        CompanionError: it cannot be written.
    """
    from companion.record.contingency_figure import ContingencyChart, draw_contingencies

    rows = {label: number for number, label in enumerate(table.labels)}
    chart = ContingencyChart(
        f"{table.mission}: {table.summary}",
        [f"{each.number} {each.place}" for each in table.positions],
        list(rows),
        {
            (rows[each.label], each.position): each.answer.verdict.letter
            for each in table.contingencies
        },
        {each.letter: each.words for each in ContingencyVerdict},
    )
    try:
        draw_contingencies(chart, path)
    except (OSError, ValueError) as error:
        raise CompanionError(f"cannot draw {path}: {error}\n    name a file .png") from error
