"""The command that checks a mission without a vehicle, with its contingencies if asked for."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from companion.cli.arguments import MissionFile
from companion.cli.log_lines import Verbose
from companion.cli.planning import FORMAT_VERSION
from companion.errors import CompanionError

if TYPE_CHECKING:
    from companion.acting.contingencies.table import ContingencyTable
    from companion.cli.checked_mission import CheckedMission

ContingenciesOption = Annotated[
    bool,
    typer.Option(
        "--contingencies",
        help="Find out what the flight does at each position of the plan if one event comes or "
        "one thing fails. Exit code 8 if the charge would not last to a safe place.",
    ),
]
PictureOption = Annotated[
    Path | None,
    typer.Option(metavar="FILE", help="With --contingencies: draw the table into a PNG file."),
]
JobsOption = Annotated[
    int | None,
    typer.Option(
        help="With --contingencies: number of processes.",
        min=1,
        show_default="one per core",
    ),
]


def check(
    mission: MissionFile,
    within: Annotated[
        Path | None,
        typer.Option(
            metavar="DIR",
            help="Refuse a mission that needs files outside of DIR, as a stranger's may.",
        ),
    ] = None,
    contingencies: ContingenciesOption = False,
    picture: PictureOption = None,
    jobs: JobsOption = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON.")] = False,
    verbose: Verbose = False,
) -> None:
    """Reads, translates and plans a mission; needs no vehicle.

    The answer says when each event holds, and which lines of the task the plan
    drops. Notices point out what is allowed but probably a mistake: an event that
    nothing uses, a line that holds from the start on, a patrol that the vehicle
    could fulfil by resting. With --contingencies the answer also says what the
    flight does if something turns out otherwise.
    """
    from companion.cli.checked_mission import check_mission
    from companion.cli.task_places import placed
    from companion.planning.explain import NoPlan

    if not contingencies and (picture or jobs):
        option = "--picture" if picture else "--jobs"
        raise typer.BadParameter("goes with --contingencies", param_hint=option)
    try:
        checked = check_mission(mission, within)
        table = _contingencies(mission, picture, jobs) if contingencies else None
    except CompanionError as error:
        refusal = placed(error, mission) if isinstance(error, NoPlan) else error
        if as_json:
            typer.echo(json.dumps(refusal_as_json(refusal)))
        raise refusal from error
    if as_json:
        told = {} if table is None else {"contingencies": table.as_json()}
        about = {"version": FORMAT_VERSION, "ok": True}
        typer.echo(json.dumps(about | checked.as_json() | told))
    else:
        _print_checked(checked)
        _print_contingencies(table)
        _print_verdict(checked, table)
    if table is not None and table.unsafe:
        from companion.cli.contingencies import UNSAFE

        raise typer.Exit(UNSAFE)


def _contingencies(mission: Path, picture: Path | None, jobs: int | None) -> ContingencyTable:
    """The table of a mission's contingencies, drawn if asked for."""
    from companion.cli.contingencies import asked_table, draw_table

    table = asked_table(mission, jobs)
    if picture is not None:
        draw_table(table, picture)
    return table


def _print_contingencies(table: ContingencyTable | None) -> None:
    if table is not None:
        from companion.cli.contingencies import print_table

        print_table(table)


def _print_verdict(checked: CheckedMission, table: ContingencyTable | None) -> None:
    """Prints the last line, which also counts the notices."""
    if table is not None and table.unsafe:
        typer.echo(f"{len(table.unsafe)} unsafe")
    elif count := len(checked.notices):
        typer.echo(f"ok, with {count} notice{'s' if count > 1 else ''}")
    else:
        typer.echo("ok")


def _print_checked(checked: CheckedMission) -> None:
    typer.echo(f"mission    {checked.mission}: places {' '.join(checked.places)}")
    if checked.earth is not None:
        typer.echo(f"earth      {checked.earth}")
    typer.echo(f"map        {checked.map}")
    for name, duration in checked.events.items():
        typer.echo(f"event      {name}: {duration}")
    for name, states in checked.states.items():
        rank = f", priority {checked.priorities[name]}" if name in checked.priorities else ""
        typer.echo(f"task       {name}: {states} state{'s' * (states != 1)}{rank}")
    typer.echo(f"plan       {checked.plan}")
    if checked.energy is not None:
        typer.echo(f"energy     {checked.energy}")
    for wait in checked.waits:
        typer.echo(f"waits      {wait}")
    if checked.land_at is not None:
        typer.echo(f"otherwise  lands at {checked.land_at}: where it is soonest")
    for line in checked.dropped:
        typer.echo(f"dropped    {line}")
    for notice in checked.notices:
        typer.echo(f"notice     {notice}")


def refusal_as_json(error: CompanionError) -> dict[str, Any]:
    """The JSON that `check --json` prints for a mission that cannot be flown."""
    refused = {"version": FORMAT_VERSION, "ok": False, "exit_code": error.exit_code}
    return refused | {"error": str(error)}
