"""The command that lists recorded runs and removes old ones: runs."""

from __future__ import annotations

import shutil
from typing import TYPE_CHECKING, Annotated

import typer

from companion.cli.arguments import DEFAULT_LOG_DIR, LogDir
from companion.errors import CompanionError

if TYPE_CHECKING:
    from companion.record.run_list import RunSummary

MB = 1e6


def runs(
    log_dir: LogDir = DEFAULT_LOG_DIR,
    newest: Annotated[
        bool, typer.Option("--newest", help="Print only the folder of the newest run.")
    ] = False,
    prune: Annotated[
        int | None,
        typer.Option(
            metavar="KEEP",
            help="Remove all runs that have ended, except the newest KEEP. Runs that were cut off "
            "are kept, because --resume may need them.",
            min=0,
        ),
    ] = None,
    yes: Annotated[
        bool, typer.Option("--yes", help="With --prune: remove without asking.")
    ] = False,
) -> None:
    """Lists the recorded runs, the newest last: when each began, how long it took, how it ended.

    \b
    Examples:
      companion runs
      companion replay "$(companion runs --newest)"
      companion runs --prune 20
    """
    from companion.record.run_list import list_runs

    found = list_runs(log_dir.expanduser())
    if not found:
        raise CompanionError(
            f"there are no runs in {log_dir}\n    companion sim surveillance makes one"
        )
    if newest:
        typer.echo(found[-1].folder)
    elif prune is not None:
        _prune(found, prune, yes)
    else:
        for run in found:
            typer.echo(_line(run))
        total = sum(run.size_bytes for run in found) / MB
        typer.echo(f"{len(found)} runs, {total:.0f} MB in {log_dir.expanduser()}")


def _line(run: RunSummary) -> str:
    minutes, seconds = divmod(int(run.length_s), 60)
    ended = (
        f"{run.ending.exit_code}  {run.ending.text}"
        if run.ending
        else "-  no end: cut off, or still flown"
    )
    first = ended.splitlines()[0]
    return (
        f"{run.folder.name:<44} {minutes:4d}:{seconds:02d} {run.size_bytes / MB:6.1f} MB  {first}"
    )


def _prune(found: list[RunSummary], keep: int, is_sure: bool) -> None:
    ended = [run for run in found if run.ending is not None]
    old = ended[: max(0, len(ended) - keep)]
    if not old:
        typer.echo(f"{len(ended)} runs have ended: nothing to remove")
        return
    size = sum(run.size_bytes for run in old) / MB
    what = f"{len(old)} runs up to {old[-1].folder.name}, {size:.0f} MB"
    if not is_sure:
        typer.confirm(f"remove {what}?", abort=True)
    for run in old:
        shutil.rmtree(run.folder)
    typer.echo(f"removed    {what}")
