"""The command that audits a recorded flight: audit."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from companion.cli.times import minutes
from companion.errors import TaskViolated, printable

if TYPE_CHECKING:
    from companion.flight_events.word import PositionLeft
    from companion.record.audit import Audit, Finding
    from companion.record.events import RunRecord

FORMAT_VERSION = 1
"""Version of the JSON that `audit --json` prints."""
SYMBOLS = {"open": ".", "true": "T", "false": "F"}
WORDS = {
    "violated": "violated at position {}",
    "unfulfilled": "not fulfilled by this rest",
    "fulfilled": "fulfilled at position {}",
    "satisfied": "satisfied by this rest",
    "open": "holds so far",
}
"""Outcomes in words; {} is the position that decides the outcome."""
IS_HELD = {
    "violated": "violated",
    "unfulfilled": "violated",
    "fulfilled": "satisfied",
    "satisfied": "satisfied",
    "open": "holds so far",
}
"""Outcomes over the whole flight, in words."""


def audit(
    run: Annotated[Path, typer.Argument(metavar="RUN", help="The folder of a run.")],
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON.")] = False,
) -> None:
    """Checks a recorded flight against its task, position by position.

    A monitor of each conjunct reads the word of the flight from RUN/events.jsonl.
    It gives one of three answers at each position: T, the conjunct is satisfied
    whatever follows; F, nothing that follows can satisfy it; or a dot, it is
    still open. Patrols stay open. If the vehicle came to rest for ever, the word
    is known to its end. Then each conjunct is also judged by the semantics of
    LTL, without any automaton.

    If an event made a line begin anew (restarts), there are two verdicts: since
    then, and over the whole flight. The first one decides the exit code.

    For a line with a priority, the positions at which it was dropped are listed.
    If it was violated, it counts from where it was taken up again. It never
    changes the exit code.

    \b
    Exit codes:
      0  the flight satisfies the task, or has not violated it so far
      2  RUN is not a run folder, or its events are lost or not as documented
      6  a conjunct that may not be dropped is violated or not fulfilled at the end

    A run that was cut off is audited up to its end. docs/run-folder.md explains
    the lines of events.jsonl.

    \b
    Examples:
      companion sim missions/surveillance.yaml --speed max --log-dir runs
      companion audit runs/2026-11-21T101500-surveillance
    """
    from companion.record.audit import as_json as for_programs
    from companion.record.audit import audit as held_against
    from companion.record.events import read_events

    record = read_events(run)
    result = held_against(record)
    if as_json:
        answer = {"version": FORMAT_VERSION, "run": str(run), **for_programs(record, result)}
        typer.echo(json.dumps(answer, indent=2))
    else:
        _print(run, record, result)
    failed = dict.fromkeys(f.name for f in result.findings if f.is_failure)
    if failed:
        raise TaskViolated(f"the flight does not satisfy the task: {', '.join(failed)}")


def _print(run: Path, record: RunRecord, result: Audit) -> None:
    ending = record.ending.text.partition("\n")[0] if record.ending else ""
    typer.echo(f"run        {run}")
    typer.echo(f"ending     {printable(ending) or 'none: the run was cut off'}")
    if not record.task:
        typer.echo("note       the mission has no task to hold the flight against")
    if record.is_torn:
        typer.echo("note       the last line of events.jsonl is not whole; it was left out")
    if record.is_headless:
        typer.echo("note       the beginning of events.jsonl was lost; the word is the journal's")
    for name, number in result.differs:
        typer.echo(f"note       not the same in flight: {name} at position {number}")
    typer.echo(f"word       {len(record.positions)} positions, a column for each conjunct below")
    for position, time_s in zip(record.positions, record.times_s, strict=True):
        typer.echo(_row(position, time_s, result.findings))
    for finding in result.findings:
        words = WORDS[finding.outcome.value].format(finding.position)
        typer.echo(f"{finding.name:<10} {words:<26} {finding.formula}")
        if finding.priority is not None:
            typer.echo(f"{'':<10} priority {finding.priority}, {_dropped(finding)}")
        if finding.since:
            whole, since = IS_HELD[finding.whole.value], IS_HELD[finding.outcome.value]
            typer.echo(
                f"{'':<10} {whole} over the whole flight; {since} since position {finding.since}"
            )


def _dropped(finding: Finding) -> str:
    """Where a line of the task was dropped, in words."""
    if not finding.dropped:
        return "never dropped"
    spans = [f"{a} to {b}" if a < b else str(a) for a, b in finding.dropped]
    is_one = len(spans) == 1 and finding.dropped[0][0] == finding.dropped[0][1]
    return f"dropped at position{'s' * (not is_one)} {', '.join(spans)}"


def _row(position: PositionLeft, time_s: float, findings: tuple[Finding, ...]) -> str:
    """A position: the state of each conjunct after it, and its facts."""
    states = "".join(SYMBOLS[finding.states[position.number].value] for finding in findings)
    notes = [f"{name} had risen" for name in sorted(position.risen)]
    notes += [f"{name} begins anew" for name in sorted(position.restarted)]
    notes += [f"{name} is dropped" for name in sorted(position.dropped)]
    withdrawn = ", ".join(sorted(position.withdrawn))
    notes += [f"without {withdrawn}"] if withdrawn else []
    notes += ["and so for ever"] if position.for_ever else []
    facts = ", ".join(sorted(position.facts))
    row = f"  {position.number:>4}  {minutes(time_s)}  {states}  {facts}"
    return row + "".join(f"; {note}" for note in notes)
