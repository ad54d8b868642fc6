"""Writes a run for tools that show logs: `companion replay RUN --mcap OUT`."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import IO, TYPE_CHECKING

import typer

from companion.errors import CompanionError, MissionError

if TYPE_CHECKING:
    from companion.flight_events.sortie import RunEnded

ATTACHED = ("mission.yaml", "scene.json", "events.jsonl", "clocks.json")
"""Files of the run that are attached, so that one file is enough."""


def write_run(run: Path, output: Path) -> None:
    """Writes a run as an MCAP file, which must not exist yet.

    Raises:
        MissionError: it is no run folder, or the file exists.
        CompanionError: the file cannot be written.
    """
    ending = look_at(run)
    try:
        with output.open("xb") as stream:
            try:
                count = _write(run, stream)
            except BaseException:
                output.unlink()
                raise
    except FileExistsError:
        raise MissionError(
            f"{output} is there already", hint="remove it, or choose another"
        ) from None
    except OSError as error:
        raise CompanionError(f"cannot write {output}: {error.strerror or error}") from error
    if ending is None:
        typer.echo("notice     the run has no end: it was cut off, or is still going on")
    typer.echo(f"written    {output}: {count} messages, {output.stat().st_size / 1e6:.1f} MB")


def look_at(run: Path) -> RunEnded | None:
    """The end of a run that will be shown, if it has one.

    If its events are lost, prints that; the rest can be shown.

    Raises:
        MissionError: the folder is no run, or damaged, as for an audit.
    """
    from companion.record.events import TLOG_FILE, EventsLost, is_lost, read_events

    try:
        return read_events(run).ending
    except EventsLost as lost:
        if is_lost(run / TLOG_FILE):
            raise
        typer.echo(f"notice     {lost.what}")
        return None


def _write(run: Path, stream: IO[bytes]) -> int:
    from companion.api.drawings import home_of_run, run_drawing
    from companion.foxglove.mcap_file import write_mcap
    from companion.foxglove.recording import RecordedRun
    from companion.plans.geojson_writing import geojson_text

    zero = home_of_run(run)
    geojson = geojson_text(run_drawing(run)) if zero is not None else None
    if zero is None:
        typer.echo("notice     the autopilot has not said where on the earth it was: no map")
    tlog = run / "flight.tlog"
    size = tlog.stat().st_size if tlog.exists() else 0
    with typer.progressbar(length=size, label="reading", file=sys.stderr) as bar:
        recorded = RecordedRun(run, zero, geojson, bar.update)
        bar.update(size)
    attachments = {name: (run / name).read_bytes() for name in ATTACHED if (run / name).exists()}
    return write_mcap(stream, recorded.start_unix_ns, recorded.messages(), attachments)
