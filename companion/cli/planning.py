"""The commands that plan without a vehicle: check and plan."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from companion.cli.arguments import MissionFile, load

if TYPE_CHECKING:
    from companion.mission.model import Mission
    from companion.planning.lasso import Lasso
    from companion.planning.planner import Planner
    from companion.planning.supposition import Supposition


def check(mission: MissionFile) -> None:
    """Reads, translates and plans a mission; needs no vehicle."""
    loaded, planner, lasso = _plan(mission)
    typer.echo(f"mission    {loaded.name}: places {' '.join(loaded.places)}")
    for conjunct in planner.conjuncts:
        typer.echo(f"task       {conjunct.name}: {conjunct.automaton.states} states")
    typer.echo(f"plan       {lasso}")
    typer.echo("ok")


def plan(
    mission: MissionFile,
    at: Annotated[str | None, typer.Option(help="Plan from this place.")] = None,
    holds: Annotated[
        list[str] | None, typer.Option("--set", metavar="FACT", help="A fact that holds.")
    ] = None,
    fails: Annotated[
        list[str] | None, typer.Option("--unset", metavar="FACT", help="A fact that does not.")
    ] = None,
    without: Annotated[
        list[str] | None,
        typer.Option(metavar="BELIEF", help="A belief that is withdrawn, e.g. canUpload(r1)."),
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON.")] = False,
) -> None:
    """Prints the plan: a prefix that is flown once and a loop that is flown for ever.

    The options ask "what if", e.g. --at A --set targetFound.
    """
    from companion.planning.supposition import Supposition

    supposed = Supposition(at, tuple(holds or ()), tuple(fails or ()), tuple(without or ()))
    _, _, lasso = _plan(mission, supposed)
    if as_json:
        typer.echo(json.dumps(lasso.as_json(), indent=2))
        return
    for title, actions in (("prefix", lasso.prefix), ("loop", lasso.suffix)):
        typer.echo(title)
        for action in actions:
            typer.echo(f"  {action.name:<24} {action.cost_ms / 1000:6.1f} s")
    typer.echo(f"prefix {lasso.prefix_cost_ms / 1000:.1f} s, lap {lasso.lap_cost_ms / 1000:.1f} s")


def _plan(path: Path, supposed: Supposition | None = None) -> tuple[Mission, Planner, Lasso]:
    """A mission and its plan, from the start or from a supposed state."""
    from companion.acting.task_state import TaskState
    from companion.app import flight_times, route_map
    from companion.planning.planner import Planner

    mission = load(path)
    planner = Planner(mission, flight_times(mission, route_map(mission)))
    task = TaskState(planner)
    if supposed is not None:
        task.facts, task.withdrawn = supposed.facts(planner), supposed.withdrawn(planner)
    return mission, planner, planner.plan(*task.problem())
