"""The page on which a run is watched: while it goes on, and afterwards (replay)."""

from __future__ import annotations

import socket
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from companion.errors import CompanionError

if TYPE_CHECKING:
    from companion.monitor.child import Show

DEFAULT_ADDRESS = "127.0.0.1:8080"
Monitor = Annotated[
    str | None,
    typer.Option(
        metavar="HOST:PORT|off",
        help="Where the page of the run is served.",
        show_default=f"{DEFAULT_ADDRESS}, off at --speed max",
    ),
]


@contextmanager
def monitored(address: str) -> Iterator[Show]:
    """Serves the page meanwhile, unless the address is `off`; gives what shows a run folder on it.

    A page that cannot be served is told and keeps nobody from flying.
    """
    host, port = _host_and_port(address)
    if not host:
        yield _show_nobody
        return
    from companion.monitor.child import listen, serving, url

    with ExitStack() as page:
        try:
            listener = listen(host, port)
            typer.echo(f"monitor    {url(listener)}")
            show = page.enter_context(serving(listener))
        except CompanionError as error:
            typer.echo(f"monitor    none: {error}", err=True)
            show = _show_nobody
        yield show


def _show_nobody(folder: Path) -> None:
    """There is no page."""


def replay(
    run: Annotated[Path, typer.Argument(metavar="RUN", help="A run folder, as sim and run print.")],
    port: Annotated[int, typer.Option(help="The page's port.", min=0, max=65535)] = 8080,
    open_page: Annotated[bool, typer.Option("--open", help="Open it in a browser.")] = False,
) -> None:
    """Shows a recorded run on the monitor page, with a slider over its time.

    The page is served on 127.0.0.1, on PORT or the next free one, until Ctrl-C. A run that was cut
    off is shown as far as it goes.

    \b
    Examples:
      companion sim missions/surveillance.yaml --speed max --log-dir runs
      companion replay runs/2026-11-21T101500-surveillance
    """
    from companion.monitor.child import listen, url
    from companion.monitor.server import replay as serve
    from companion.record.events import read_events

    read_events(run)  # says what is wrong with a folder, as an audit does
    with listen("127.0.0.1", port) as listener:
        typer.echo(f"monitor    {url(listener)}    Ctrl-C ends it")
        if open_page:
            typer.launch(url(listener))
        serve(listener, run)


def monitor(listener: Annotated[int, typer.Argument(help="An open socket's number.")]) -> None:
    """Serves the page of a flight whose process has started this one."""
    try:
        from companion.monitor.server import follow

        follow(socket.socket(fileno=listener))
    except (ImportError, OSError, CompanionError) as error:
        raise CompanionError(f"monitor    ended, the flight goes on: {error}") from error


def _host_and_port(address: str) -> tuple[str, int]:
    """("", 0) for `off`."""
    if address == "off":
        return ("", 0)
    host, colon, port = address.rpartition(":")
    if not colon or not host or not port.isdecimal() or int(port) > 65535:
        raise typer.BadParameter(f"{address} is neither HOST:PORT nor off", param_hint="--monitor")
    return (host.strip("[]"), int(port))
