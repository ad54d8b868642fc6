"""The commands: each parses its arguments and makes one call. Only this package prints and exits.

Exit codes: 0 the task is satisfied (or the run was stopped on request), 1 internal error, 2 an
input file or the command line is wrong, 3 no plan, 4 no link, 5 the pilot or a failsafe ended the
flight, or it did not begin, 6 a recorded flight does not satisfy its task (`audit`), failures were
found (`falsify`), or rows fail that did not before (`campaign --against`), 7 the search for a plan
was given up at a limit, 8 a contingency is unsafe (`check --contingencies`).

Slow imports (MAVLink, plots, the simulator) are inside the commands that need them, so that
`--help` answers at once.
"""

from __future__ import annotations

import os
import stat
import sys
from typing import Annotated

import typer

from companion.cli.auditing import audit
from companion.cli.campaigns import campaign
from companion.cli.checking import check
from companion.cli.doctor import doctor
from companion.cli.falsifying import falsify
from companion.cli.figures import figure
from companion.cli.flying import run
from companion.cli.formulas import ltl
from companion.cli.keys import key
from companion.cli.monitoring import monitor, replay
from companion.cli.new import new
from companion.cli.operating import upload, watch
from companion.cli.plan_files import export, import_
from companion.cli.planning import plan
from companion.cli.runs import runs
from companion.cli.shipped import DISTRIBUTION
from companion.cli.simulated_flight import sim
from companion.cli.skills import skills
from companion.cli.terminal import give_up
from companion.cli.trees import tree
from companion.cli.words import WordyGroup
from companion.errors import CompanionError

OTHERS_WRITE = stat.S_IWGRP | stat.S_IWOTH

app = typer.Typer(
    cls=WordyGroup,
    context_settings={"help_option_names": ["--help", "-h"]},
    help="Plans a mission in linear temporal logic and flies it on a PX4-style vehicle.",
    epilog="Try: companion sim surveillance --speed max",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
)
for command in (
    new,
    check,
    plan,
    tree,
    ltl,
    run,
    sim,
    campaign,
    falsify,
    audit,
    replay,
    runs,
    upload,
    watch,
    export,
    figure,
    skills,
    doctor,
):
    app.command()(command)
app.command("import")(import_)
app.add_typer(key, name="key")
app.command(hidden=True)(monitor)


def _print_version(is_wanted: bool) -> None:
    if is_wanted:
        from importlib import metadata

        typer.echo(f"companion {metadata.version(DISTRIBUTION)}")
        raise typer.Exit


@app.callback()
def _options(
    version: Annotated[
        bool,
        typer.Option(
            "--version", callback=_print_version, is_eager=True, help="Print the version."
        ),
    ] = False,
) -> None:
    """Options that belong to no command."""


def main() -> None:
    """Entry point: runs a command and turns errors into messages and exit codes.

    Only the user can change files that a command or its children write: the umask denies it to
    others.
    """
    os.umask(os.umask(OTHERS_WRITE) | OTHERS_WRITE)
    try:
        app(standalone_mode=True)
    except CompanionError as error:
        _print_error(str(error))
        sys.exit(error.exit_code)
    except OSError as error:
        if error.filename is not None:
            raise
        give_up(sys.stdout)
        _print_error(f"cannot write the output: {error.strerror}")
        sys.exit(1)


def _print_error(text: str) -> None:
    """Prints on standard error, if that can still be read; the exit code says the same."""
    try:
        typer.echo(text, err=True)
    except OSError:
        give_up(sys.stderr)
