"""The command that writes a mission as a starting point: new."""

from __future__ import annotations

import re
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated

import typer

from companion.cli.arguments import load
from companion.cli.plan_files import HOME, origin_of
from companion.errors import MissionError
from companion.plans.starter import PX4_HOME, SPACES, StarterSpace, starter
from companion.plans.starter_tasks import TASKS, TaskName

_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]*")


def new(
    name: Annotated[str, typer.Argument(help="Name of the mission and of its two files.")],
    space: Annotated[
        StarterSpace | None,
        typer.Option(help="Where the mission is flown.", show_default="asked for, or field"),
    ] = None,
    task: Annotated[
        TaskName | None,
        typer.Option(help="What the mission does.", show_default="asked for, or patrol"),
    ] = None,
    home: Annotated[
        str | None,
        typer.Option(
            metavar=HOME,
            help="With --space earth: where the mission begins.",
            show_default="PX4's simulated home",
        ),
    ] = None,
) -> None:
    """Writes a mission with comments and its simulated world to start from, and checks it.

    The files NAME.yaml and NAME.sim.yaml are written to the present folder. The
    command asks for what no option says.

    \b
    Examples:
      companion new harbour --space earth --task inspection --home 53.5436,9.9880
      companion sim harbour.yaml --speed max
    """
    from companion.planning.planner import Planner

    if not _NAME.fullmatch(name):
        raise MissionError(f"{name!r} is not a name", hint="letters, digits and _, a letter first")
    spaces = {name.value: about for name, about in SPACES.items()}
    tasks = {name.value: each.question for name, each in TASKS.items()}
    where = space or StarterSpace(_asked("space", spaces, StarterSpace.FIELD))
    if home is not None and where is not StarterSpace.EARTH:
        reason = f"is of --space earth; a mission in the space {where} is in metres from home"
        raise typer.BadParameter(reason, param_hint="--home")
    what = task or TaskName(_asked("task", tasks, TaskName.PATROL))
    made = starter(name, where, what, origin_of(home) or PX4_HOME)
    mission, world = Path(f"{name}.yaml"), Path(f"{name}.sim.yaml")
    for path in (mission, world):
        if path.exists():
            raise MissionError(f"{path} is there already", hint="remove it, or choose another name")
    mission.write_text(made.mission, encoding="utf-8")
    world.write_text(made.world, encoding="utf-8")
    plan = Planner(load(mission)).plan()
    typer.echo(f"written    {mission}, {world}")
    typer.echo(f"plan       {plan.lasso}")
    typer.echo(f"next       companion sim {mission} --speed max")


def _asked(what: str, choices: Mapping[str, str], default: str) -> str:
    """The answer of the user at a terminal; without one, the default."""
    if not sys.stdin.isatty():
        return default
    for name, about in choices.items():
        typer.echo(f"  {name:<11} {about}")

    def chosen(text: str) -> str:
        if text not in choices:
            raise typer.BadParameter(f"{text} is not one of {', '.join(choices)}")
        return text

    return str(typer.prompt(what, default=default, value_proc=chosen))
