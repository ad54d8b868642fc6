"""The command for keys of message signing."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

KeyFile = Annotated[Path, typer.Argument(metavar="FILE", help="The key file.")]

key = typer.Typer(
    help="Makes and shows a key for MAVLink message signing.",
    epilog="Try: companion key make vehicle.key",
    no_args_is_help=True,
)


@key.command()
def make(
    file: KeyFile,
    passphrase: Annotated[
        bool,
        typer.Option("--passphrase", help="Ask for a passphrase, as QGroundControl does."),
    ] = False,
) -> None:
    """Makes a key file that only its owner can read.

    Who has the key can command the vehicle; without it, messages are refused. Give the same key to
    all: a copy of the file to `companion run`, `upload` and `watch` and to `sitl`
    (--signing-key FILE), its passphrase to QGroundControl, which hands it on to PX4, over a cable.

    Without --passphrase the key is random, which nobody can guess.
    """
    from companion.mavlink.key_file import make_key

    words: str | None = None
    if passphrase:
        words = typer.prompt("passphrase", hide_input=True, confirmation_prompt=True)
    make_key(file, words)
    typer.echo(f"made       {file}; keep it secret, and give each machine a copy")


@key.command()
def show(file: KeyFile) -> None:
    """Prints a key as 64 hexadecimal digits, for programs that take no file. Mind who looks on."""
    from companion.mavlink.key_file import read_key

    typer.echo(read_key(file).secret.hex())
