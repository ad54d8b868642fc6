"""The command that draws a recorded run: figure."""

from __future__ import annotations

from enum import Enum
from pathlib import Path
from typing import Annotated

import typer

from companion.errors import CompanionError


class FigureFormat(Enum):
    """File formats."""

    PDF = "pdf"
    SVG = "svg"
    PNG = "png"


def figure(
    run: Annotated[
        Path,
        typer.Argument(metavar="RUN", help="The folder of a run. `companion runs` lists them."),
    ],
    format_: Annotated[
        FigureFormat, typer.Option("--format", help="Format of the file, without --output.")
    ] = FigureFormat.PDF,
    output: Annotated[
        Path | None,
        typer.Option(
            "--output",
            "-o",
            metavar="FILE",
            help="FILE.pdf, FILE.svg or FILE.png. An existing file is overwritten.",
            show_default="flight.FORMAT in RUN",
        ),
    ] = None,
) -> None:
    """Draws the path of a recorded flight, with a panel for each plan, for a paper or a report."""
    path = output or run / f"flight.{format_.value}"
    kinds = [f".{each.value}" for each in FigureFormat]
    if path.suffix.lower() not in kinds:
        reason = f"{path.name} is not one of {', '.join(kinds)}"
        raise typer.BadParameter(reason, param_hint="--output")
    from companion.api.figures import backdrop_of_run, trail_of_run
    from companion.record.figure import draw_flight

    backdrop, trail = backdrop_of_run(run), trail_of_run(run)
    try:
        draw_flight(backdrop, trail, path)
    except OSError as error:
        raise CompanionError(f"cannot write {path}: {error.strerror or error}") from error
    typer.echo(f"written    {path}")
