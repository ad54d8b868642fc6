"""The monitor page of a program's flights, which is served by a process of its own."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from companion.errors import CompanionError
from companion.monitor.child import Child, listen, url


@dataclass(frozen=True)
class PageOptions:
    """Where the page is served, and whether it is.

    Attributes:
        host, port: where it is served; on the next free port if this one is in use.
        is_on: whether it is served from the start; an operator can change this.
    """

    host: str = "127.0.0.1"
    port: int = 8080
    is_on: bool = True


class Page:
    """The page of this program's runs, served or not; a `ground.operations.MonitorPage`.

    A page that cannot be served is reported and stops no flight.

    Args:
        options: where it is served; once it was served, it does not move.
        say: prints a line, on standard error if it is an error.
    """

    def __init__(self, options: PageOptions, say: Callable[[str, bool], None]) -> None:
        self._address = (options.host, options.port)
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
def monitored(
    options: PageOptions, say: Callable[[str, bool], None], folder: Path | None = None
) -> Iterator[Page]:
    """The page of the runs in this context.

    Args:
        options: where it is served.
        say: prints a line, on standard error if it is an error.
        folder: the run that it shows first; None if there is none yet.
    """
    page = Page(options, say)
    if folder is not None:
        page.show(folder)
    try:
        if options.is_on:
            page.switch(True)
        yield page
    finally:
        page.close()
