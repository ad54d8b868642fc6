"""The command that flies a mission many times in varied worlds: campaign."""

from __future__ import annotations

import shlex
import sys
import time
from collections.abc import Iterator
from contextlib import closing, contextmanager
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from companion.cli.arguments import MissionFile, load
from companion.cli.simulated_flight import ScenarioFile
from companion.errors import CompanionError, LinkError, MissionError, RequestError, TaskViolated

if TYPE_CHECKING:
    from rich.progress import Progress

    from companion.campaigns.campaign import Campaign
    from companion.campaigns.kit import Kit
    from companion.campaigns.outcomes import FlownRow
    from companion.campaigns.processes import RowEngine

Jobs = Annotated[
    int | None,
    typer.Option(
        help="Number of processes that fly at the same time.", min=1, show_default="one per core"
    ),
]
CampaignSeed = Annotated[
    int, typer.Option(help="Seed from which the values of all rows are drawn.", min=0)
]
RowLimit = Annotated[
    float,
    typer.Option(
        "--limit-s",
        help="End a flight after this many simulated seconds, with the outcome `limit`.",
        min=1.0,
    ),
]
OutFolder = Annotated[
    Path | None,
    typer.Option(
        "--out", metavar="DIR", help="Folder for the results.", show_default="campaign-NAME"
    ),
]
SearchFolder = Annotated[
    Path | None,
    typer.Option(
        "--out", metavar="DIR", help="Folder for the results.", show_default="falsify-NAME"
    ),
]
ResumedFolder = Annotated[
    Path | None,
    typer.Option(
        "--resume",
        metavar="DIR",
        help="Continue the campaign in DIR, with the options with which it was begun.",
    ),
]
DaskAddress = Annotated[
    str | None,
    typer.Option("--dask", metavar="ADDRESS", help="Fly on a Dask cluster, e.g. tcp://HOST:8786."),
]
OtherTable = Annotated[
    Path | None,
    typer.Option(
        "--against",
        metavar="TABLE",
        help="Compare with the table of an earlier campaign that flew the same rows.",
    ),
]
LIMIT_S = 1800.0
RUNS_MAX = 1_000_000
"""Most flights of a campaign; drawing this many rows before the first flight takes minutes."""
PLAIN_TELLINGS = 10
"""How often progress is printed where there is no terminal."""


def campaign(
    context: typer.Context,
    mission: MissionFile,
    runs: Annotated[int, typer.Option(help="Number of flights.", min=1, max=RUNS_MAX)] = 100,
    seed: CampaignSeed = 0,
    scenario: ScenarioFile = None,
    jobs: Jobs = None,
    limit_s: RowLimit = LIMIT_S,
    out: OutFolder = None,
    resume: ResumedFolder = None,
    dask: DaskAddress = None,
    against: OtherTable = None,
) -> None:
    """Flies a mission many times in worlds that vary, and writes a table of all flights.

    The key `vary` of the scenario says what varies. Without it, only the seed of
    each flight does. A row depends on nothing but its number and --seed. So the
    table is the same, byte for byte, for any number of processes, on a cluster,
    and after --resume. See docs/campaigns.md.

    \b
    Examples:
      companion campaign missions/surveillance.yaml --runs 300 --seed 1
      companion campaign missions/surveillance.yaml --resume campaign-surveillance

    \b
    Exit codes:
      0  all rows were flown, however they ended
      6  with --against: at least one row fails that did not fail before
    """
    from companion.campaigns.campaign import random_rows
    from companion.campaigns.statistics import compare
    from companion.campaigns.summary import earlier_table, failures_in, in_words
    from companion.campaigns.table import read_table

    folder = resume or out or Path(f"campaign-{mission.stem}")
    if resume is not None:
        runs, seed, limit_s = begun_with(context, resume, "runs")
    kit = kit_of(mission, scenario, limit_s)
    header = kit.header(seed, runs=runs)
    earlier = earlier_table(against, header) if against else None
    line = partial(command_line, "campaign", mission, scenario)
    again, command = line(resume=folder), line(runs=runs, seed=seed, limit_s=f"{limit_s:g}")
    with begun(kit, folder, header, runs, jobs, dask, again) as (flights, _):
        flights.flown(random_rows(kit, seed, runs))
        table = finish(flights, mission, command)
    if against is not None and earlier is not None:
        found = compare(failures_in(earlier), failures_in(read_table(table)))
        typer.echo(in_words(against, found))
        if not found.rows:
            raise MissionError(f"no row counts in both {against} and {table}")
        if found.worse:
            raise TaskViolated(f"rows that fail and did not before: {len(found.worse)}")


def begun_with(context: typer.Context, folder: Path, count: str) -> tuple[int, int, float]:
    """The options with which the campaign in a folder was started.

    Args:
        context: the context of the command that continues it.
        folder: the folder of the campaign.
        count: the option that is its number of rows.

    Returns:
        The number of rows, the seed, and the limit in seconds.

    Raises:
        MissionError: there is no such campaign.
        RequestError: the command line gives other values.
    """
    from companion.campaigns.row_file import header_in

    header = header_in(folder, count)
    try:
        begun = {count: int(header[count]), "seed": int(header["seed"])}
        limit_s = float(header["limit_s"])
    except (KeyError, TypeError, ValueError) as error:
        raise MissionError(
            f"the header of {folder} is not that of a campaign ({error!r})"
        ) from error
    for name, value in {**begun, "limit_s": limit_s, "out": folder}.items():
        source = context.get_parameter_source(name)
        if source is not None and source.name == "COMMANDLINE" and context.params[name] != value:
            option = f"--{name.replace('_', '-')}"
            raise RequestError(
                f"{option} {context.params[name]} does not go with --resume: the campaign in "
                f"{folder} has {value}\n    leave {option} out, or begin another one with --out"
            )
    return begun[count], begun["seed"], limit_s


def command_line(name: str, mission: Path, scenario: Path | None, **options: object) -> str:
    """A command as it is typed.

    >>> command_line("campaign", Path("m.yaml"), None, runs=300, limit_s=900)
    'companion campaign m.yaml --runs 300 --limit-s 900'
    >>> command_line("campaign", Path("my m.yaml"), None)
    "companion campaign 'my m.yaml'"
    """
    given = options | ({"scenario": scenario} if scenario else {})
    said = ((f"--{key.replace('_', '-')}", str(value)) for key, value in given.items())
    return shlex.join(["companion", name, str(mission), *(word for pair in said for word in pair)])


def kit_of(mission: Path, scenario: Path | None, limit_s: float) -> Kit:
    """The kit of a mission file and its scenario."""
    from companion.campaigns.kit import Kit
    from companion.flights.simulated_world import scenario_beside, varied_world_of, world_in_words

    loaded, limit_s = load(mission), float(f"{limit_s:g}")  # rounded as in the table's header
    world = world_in_words(loaded, scenario or scenario_beside(loaded))
    typer.echo(f"world      {world}", err=True)
    return Kit.of(loaded, varied_world_of(loaded, scenario), limit_s)


@contextmanager
def begun(
    kit: Kit,
    folder: Path,
    header: dict[str, str],
    total: int,
    jobs: int | None,
    dask: str | None,
    again: str,
) -> Iterator[tuple[Campaign, Tell]]:
    """A campaign, and the printer of its progress, while the context lasts.

    Args:
        kit: mission and scenario.
        folder: where to write it.
        header: the header of its table.
        total: expected number of rows.
        jobs: processes; None means one per core.
        dask: the address of a cluster; None means processes of this machine.
        again: the command that continues it, printed when it is stopped.
    """
    from companion.campaigns.campaign import Campaign, Interrupted
    from companion.campaigns.row_file import NotWritten

    engine = engine_of(kit, jobs, dask)
    with closing(engine), _progress(total) as tell:
        flights = Campaign(kit, engine, folder, header, tell, tell.kept)
        try:
            yield flights, tell
        except (Interrupted, NotWritten, LinkError, KeyboardInterrupt) as error:
            kept = f"{str(error) or 'stopped'}\n    {len(flights.rows)} rows are kept"
            raise CompanionError(f"{kept}\n    to go on: {again}") from None
        finally:
            flights.close()


def engine_of(kit: Kit, jobs: int | None, dask: str | None) -> RowEngine:
    """The engine that flies the rows."""
    from companion.api.contingency_answers import usable_cores
    from companion.campaigns.dask_cluster import DaskCluster
    from companion.campaigns.processes import LocalProcesses

    if dask is None:
        return LocalProcesses(kit.packed, jobs or usable_cores())
    cluster = DaskCluster(kit.packed, dask)
    typer.echo(f"cluster    {cluster.threads} threads", err=True)
    if cluster.busiest > 1:
        typer.echo("           flights of one process wait for each other: --nthreads 1", err=True)
    return cluster


def finish(flights: Campaign, mission: Path, command: str) -> Path:
    """Writes the table and the report, prints a summary, and returns the table's path."""
    from companion.campaigns.report import write_report

    table = flights.write_table()
    tell_outcomes(flights)
    typer.echo(f"table      {table}")
    typer.echo(f"report     {write_report(flights, mission, command)}")
    return table


def tell_outcomes(flights: Campaign, is_search: bool = False) -> None:
    """Prints how many rows ended in each way; chosen rows, of a search, have no rates."""
    from companion.campaigns.outcomes import RowOutcome
    from companion.campaigns.statistics import Rate
    from companion.campaigns.summary import summary, why_invalid

    valid = sum(each.outcome.is_valid for each in flights.rows)
    for name, count, is_failure in summary(flights.rows):
        if name == RowOutcome.INVALID.value:
            said = why_invalid(flights.rows)
        else:
            said = "" if is_search else str(Rate.of(count, valid))
        line = f"{'FAILED ' if is_failure else '       '}{count:>6}  {name:<28} {said}"
        typer.echo(line.rstrip())


@contextmanager
def _progress(total: int) -> Iterator[Tell]:
    from rich.console import Console
    from rich.progress import (
        BarColumn,
        MofNCompleteColumn,
        Progress,
        TextColumn,
        TimeRemainingColumn,
    )

    console = Console(stderr=True)
    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        TextColumn("{task.fields[rate]}"),
        TextColumn("{task.fields[failures]} failed"),
        TimeRemainingColumn(),
    )
    bar = Progress(*columns, console=console, transient=True, disable=not sys.stderr.isatty())
    with bar:
        yield Tell(bar, total)


class Tell:
    """Prints the progress of a campaign: a bar on a terminal, otherwise a line now and then.

    Args:
        bar: drawn, or disabled.
        total: expected number of rows.
    """

    def __init__(self, bar: Progress, total: int) -> None:
        self._bar = bar
        self._task = bar.add_task("", rate="", failures=0)
        self.begin("flown", total)

    def begin(self, what: str, total: int | None) -> None:
        """Begins a new stage; `total` may be unknown."""
        self._what, self._total = what, total
        self._done = self._failures = self._kept = 0
        self._started_s = time.monotonic()
        self._bar.update(self._task, description=what, completed=0, total=total)

    def kept(self, flown: FlownRow) -> None:
        """Counts a row that the folder already had."""
        self._done += 1
        self._kept += 1
        self._failures += flown.is_failure

    def __call__(self, flown: FlownRow) -> None:
        """Counts a row that has been flown."""
        self._done += 1
        self._failures += flown.is_failure
        rate = (self._done - self._kept) / max(time.monotonic() - self._started_s, 1e-3)
        said = f"{rate:.2f} flights/s"
        self._bar.update(self._task, completed=self._done, rate=said, failures=self._failures)
        every = max(1, self._total // PLAIN_TELLINGS) if self._total else PLAIN_TELLINGS
        if self._bar.disable and (self._done % every == 0 or self._done == self._total):
            count = f"{self._done} of {self._total}" if self._total else f"{self._done} flights"
            failed = f"{self._failures} failed, {said}"
            typer.echo(f"{self._what:<10} {count}, {failed}", err=True)
