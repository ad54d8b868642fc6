"""The page on which a run is watched: the option of commands that fly, and replay."""

from __future__ import annotations

import socket
from pathlib import Path
from typing import Annotated

import typer

from companion.cli.log_files import look_at, write_run
from companion.errors import CompanionError
from companion.flights.monitor_page import PageOptions
from companion.monitor.child import listen, url

DEFAULT_PAGE = PageOptions()


def page_options(address: str) -> PageOptions:
    """The page of an option's value: HOST:PORT, or off.

    >>> page_options("[::1]:80")
    PageOptions(host='::1', port=80, is_on=True)

    Raises:
        BadParameter: it is neither of these.
    """
    if address == "off":
        return PageOptions(is_on=False)
    host, colon, port = address.rpartition(":")
    if not colon or not host or not port.isdecimal() or int(port) > 65535:
        raise typer.BadParameter(f"{address} is neither HOST:PORT nor off", param_hint="--monitor")
    return PageOptions(host.strip("[]"), int(port))


Monitor = Annotated[
    PageOptions | None,
    typer.Option(
        parser=page_options,
        metavar="HOST:PORT|off",
        help="Address of the monitor page, or off: no page.",
        show_default=f"{DEFAULT_PAGE.host}:{DEFAULT_PAGE.port}, off at --speed max",
    ),
]


def replay(
    run: Annotated[Path, typer.Argument(metavar="RUN", help="The folder of a run.")],
    port: Annotated[int, typer.Option(help="Port of the page.", min=0, max=65535)] = 8080,
    open_page: Annotated[bool, typer.Option("--open", help="Open the page in a browser.")] = False,
    mcap: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE", help="Write the run to a new file for Foxglove, and serve no page."
        ),
    ] = None,
) -> None:
    """Shows a recorded run on the monitor page, with a slider over its time.

    The page is served on 127.0.0.1, on PORT or the next free one, until you press
    Ctrl-C. A run that was cut off is shown up to its end. With --mcap the run is
    written to a file instead.

    \b
    Examples:
      companion sim missions/surveillance.yaml --speed max --log-dir runs
      companion replay runs/2026-11-21T101500-surveillance
      companion replay runs/2026-11-21T101500-surveillance --mcap surveillance.mcap
    """
    if mcap is not None:
        write_run(run, mcap)
        return
    from companion.monitor.server import replay as serve

    look_at(run)
    with listen("127.0.0.1", port) as listener:
        typer.echo(f"monitor    {url(listener)}    Ctrl-C ends it")
        if open_page:
            typer.launch(url(listener))
        serve(listener, run)


def monitor(listener: Annotated[int, typer.Argument(help="An open socket's number.")]) -> None:
    """Serves the page of a flight, as a child process of the flight."""
    try:
        from companion.monitor.server import follow

        follow(socket.socket(fileno=listener))
    except (ImportError, OSError, CompanionError) as error:
        raise CompanionError(f"monitor    ended, the flight goes on: {error}") from error
