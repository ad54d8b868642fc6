"""The page on which a run is watched: during the run, and afterwards (replay)."""

from __future__ import annotations

import socket
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated

import typer

from companion.cli.log_files import look_at, write_run
from companion.errors import CompanionError
from companion.monitor.child import Child, listen, url

DEFAULT_ADDRESS = "127.0.0.1:8080"


def _checked(address: str | None) -> str | None:
    """Refuses an invalid address before anything is recorded."""
    if address not in (None, "off"):
        _host_and_port(address)
    return address


Monitor = Annotated[
    str | None,
    typer.Option(
        callback=_checked,
        metavar="HOST:PORT|off",
        help="Address of the monitor page, or off: no page.",
        show_default=f"{DEFAULT_ADDRESS}, off at --speed max",
    ),
]


class Page:
    """The page of this program's runs, served or not; a `ground.operations.MonitorPage`.

    A page that cannot be served is reported and stops no flight.

    Args:
        host: where it is served; it does not move afterwards.
        port: likewise; the next free one if it is in use.
        say: prints a line, on standard error if it is an error.
    """

    def __init__(self, host: str, port: int, say: Callable[[str, bool], None]) -> None:
        self._address = (host, port)
        self._say = say
        self._child: Child | None = None
        self._folder: Path | None = None

    @property
    def is_served(self) -> bool:
        """Whether the page is served; it may end by itself."""
        return self._child is not None and self._child.is_running

    def switch(self, is_on: bool) -> str:
        """Starts or ends serving, if possible; prints and returns a line for people."""
        try:
            text = self._serve() if is_on else self._end()
        except CompanionError as error:
            text = f"none: {error}"
        self._say(f"monitor    {text}", self.is_served != is_on)
        return f"monitor page {text}"

    def show(self, folder: Path) -> None:
        """Shows the run in a folder from now on."""
        self._folder = folder
        if self._child is not None:
            self._child.show(folder)

    def close(self) -> None:
        """Ends the page with the program; browsers can still read the end."""
        if self._child is not None:
            self._child.close()

    def _serve(self) -> str:
        listener = listen(*self._address)
        address = url(listener)
        self._address = listener.getsockname()[:2]
        self._child = Child(listener)
        if self._folder is not None:
            self._child.show(self._folder)
        return address

    def _end(self) -> str:
        if self._child is not None:
            self._child.kill()
            self._child = None
        return "off"


@contextmanager
def monitored(address: str, say: Callable[[str, bool], None]) -> Iterator[Page]:
    """The page of the runs in this context, served from the start unless the address is `off`."""
    is_off = address == "off"
    page = Page(*_host_and_port(DEFAULT_ADDRESS if is_off else address), say)
    try:
        if not is_off:
            page.switch(True)
        yield page
    finally:
        page.close()


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


def _host_and_port(address: str) -> tuple[str, int]:
    host, colon, port = address.rpartition(":")
    if not colon or not host or not port.isdecimal() or int(port) > 65535:
        raise typer.BadParameter(f"{address} is neither HOST:PORT nor off", param_hint="--monitor")
    return (host.strip("[]"), int(port))
