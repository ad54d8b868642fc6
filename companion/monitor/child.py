"""The monitor page of a flight, as a process of its own: no browser can delay a tick.

The flight's process only opens the port, so that its address is known at once and it waits for
nobody, and hands it on. The child is told by a pipe which run folder to show, and ends when that
pipe is closed, however the flight's process has ended. If it cannot start it says so itself, and
the flight goes on.
"""

from __future__ import annotations

import contextlib
import errno
import socket
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from companion.errors import LinkError

PORTS_TRIED = 50

Show = Callable[[Path], None]
"""Shows the run of a folder from now on."""


def listen(host: str, port: int) -> socket.socket:
    """A socket on this port, or on the next one that is free.

    Raises:
        LinkError: there is none.
    """
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    failure: OSError | None = None
    for candidate in range(port, min(port + PORTS_TRIED, 65536)):
        listener = socket.socket(family, socket.SOCK_STREAM)
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            listener.bind((host, candidate))
            listener.listen(128)
            return listener
        except OSError as error:
            listener.close()
            failure = error
            if error.errno != errno.EADDRINUSE:
                break
    why = failure.strerror if failure else "no such port"
    raise LinkError(f"the monitor cannot listen on {host}:{port}: {why}")


def url(listener: socket.socket) -> str:
    """Where a browser finds it."""
    host, port = listener.getsockname()[:2]
    return f"http://{f'[{host}]' if ':' in host else host}:{port}"


@contextmanager
def serving(listener: socket.socket) -> Iterator[Show]:
    """Serves the page for as long as the context lasts, of the run that was given to it last.

    Takes the socket over. A run's folder has to be there, with its scene.

    Raises:
        LinkError: no process can be started.
    """
    number = listener.fileno()
    with listener:
        try:
            child = subprocess.Popen(
                [sys.executable, "-m", "companion", "monitor", str(number)],
                stdin=subprocess.PIPE,
                stdout=subprocess.DEVNULL,
                pass_fds=[number],
                start_new_session=True,  # Ctrl-C is the flight's: the landing is to be seen
            )
        except OSError as error:
            raise LinkError(f"the monitor cannot start: {error}") from error
    assert child.stdin is not None
    pipe = child.stdin

    def show(folder: Path) -> None:
        with contextlib.suppress(OSError):  # it has ended, and has said so
            pipe.write(f"{folder.absolute()}\n".encode())
            pipe.flush()

    try:
        yield show
    finally:
        with contextlib.suppress(OSError):
            pipe.close()
