"""The command that searches for a world in which a mission fails: falsify."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Annotated

import typer

from companion.cli.arguments import MissionFile
from companion.cli.campaigns import (
    LIMIT_S,
    RUNS_MAX,
    CampaignSeed,
    DaskAddress,
    Jobs,
    ResumedFolder,
    RowLimit,
    SearchFolder,
    begun,
    begun_with,
    command_line,
    engine_of,
    kit_of,
    tell_outcomes,
)
from companion.cli.simulated_flight import ScenarioFile
from companion.errors import MissionError, TaskViolated


def falsify(
    context: typer.Context,
    mission: MissionFile,
    budget: Annotated[
        int, typer.Option(help="Number of flights of the search.", min=16, max=RUNS_MAX)
    ] = 150,
    seed: CampaignSeed = 0,
    scenario: ScenarioFile = None,
    jobs: Jobs = None,
    limit_s: RowLimit = LIMIT_S,
    out: SearchFolder = None,
    resume: ResumedFolder = None,
    dask: DaskAddress = None,
) -> None:
    """Searches the worlds that `vary` allows for some in which the mission fails.

    The first flights cover the range of each value evenly. Then CMA-ES searches
    where the margins are least. Each different failure is made as simple as
    possible, in 20 to 60 flights beyond the budget, and written as a scenario
    file with the command that repeats it. See docs/campaigns.md.

    \b
    Exit codes:
      0  no failure was found
      6  failures were found
    """
    from companion.campaigns.falsification import checked, minimise
    from companion.campaigns.falsification import falsify as searched
    from companion.campaigns.report import write_report

    folder = resume or out or Path(f"falsify-{mission.stem}")
    if resume is not None:
        budget, seed, limit_s = begun_with(context, resume, "budget")
    kit = kit_of(mission, scenario, limit_s)
    if not kit.factors:
        what = "there is nothing to search: the scenario has no key vary"
        raise MissionError(what, hint="say what varies (docs/campaigns.md), or fly a campaign")
    line = partial(command_line, "falsify", mission, scenario)
    again, command = line(resume=folder), line(budget=budget, seed=seed, limit_s=f"{limit_s:g}")
    header = kit.header(seed, budget=budget)
    with begun(kit, folder, header, budget, jobs, dask, again) as (search, tell):
        failures = searched(search, seed, budget)
        found = f"failures that differ in kind or place: {len(failures)}"
        if failures:
            typer.echo(f"simpler    {found}", err=True)
            tell.begin("simpler", None)
        simple = minimise(search, failures, lambda kit: engine_of(kit, jobs, dask), tell)
        cases = checked(search, mission, simple)
        tell_outcomes(search, is_search=True)
        typer.echo(f"table      {search.folder / 'table.csv'}")
        typer.echo(f"report     {write_report(search, mission, command, is_search=True)}")
        for each in cases:
            kind, where = each.case.flown.kind, each.case.flown.place
            typer.echo(f"\nfailure    {kind}, near {where}" if where else f"\nfailure    {kind}")
            typer.echo(f"scenario   {each.case.file}")
            said = "the same" if each.is_repeated else "NOT repeated by its file alone"
            typer.echo(f"repeat     {each.case.line}\n           in a fresh process: {said}")
    if failures:
        raise TaskViolated(found)
