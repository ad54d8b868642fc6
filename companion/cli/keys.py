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
        typer.Option(
            "--passphrase",
            help="Ask for a passphrase and make the key from it, as QGroundControl does.",
        ),
    ] = False,
) -> None:
    """Makes a key file that only its owner can read.

    Whoever has the key can command the vehicle. Messages without it are refused.
    All sides need the same key. Give a copy of the file to `companion run`,
    `upload` and `watch` and to `sitl` (--signing-key FILE). Give the passphrase
    to QGroundControl, which sends the key to PX4. Do that over a cable.

    Without --passphrase the key is random, so nobody can guess it.
    """
    from companion.mavlink.key_file import make_key

    words: str | None = None
    if passphrase:
        words = typer.prompt("passphrase", hide_input=True, confirmation_prompt=True)
    make_key(file, words)
    typer.echo(f"made       {file}; keep it secret, and give each machine a copy")


@key.command()
def show(file: KeyFile) -> None:
    """Prints a key as 64 hexadecimal digits, for programs that take no file. Let nobody watch."""
    from companion.mavlink.key_file import read_key

    typer.echo(read_key(file).secret.hex())
