"""The monitor page of a flight, in its own process, so that no browser can delay a tick.

1. The flight's process only opens the port, so its address is known at once without waiting, and
   hands it on.
2. A pipe tells the child which run folder to show. The child ends when the pipe is closed, however
   the flight's process has ended.
3. If the child cannot start, it reports this itself, and the flight continues.
"""

from __future__ import annotations

import contextlib
import errno
import socket
import subprocess
import sys
from pathlib import Path

from companion.errors import LinkError
from companion.python_child import python_module

PORTS_TRIED = 50
STALLED_MS = 10_000
"""A browser that reads nothing for this long is disconnected; connections inherit this."""


def listen(host: str, port: int) -> socket.socket:
    """A socket on this port, or on the next free one.

    Raises:
        LinkError: there is none.
    """
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    failure: OSError | None = None
    for candidate in range(port, min(port + PORTS_TRIED, 65536)):
        listener = socket.socket(family, socket.SOCK_STREAM)
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            if sys.platform == "linux":
                listener.setsockopt(socket.IPPROTO_TCP, socket.TCP_USER_TIMEOUT, STALLED_MS)
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
    """The address for a browser."""
    host, port = listener.getsockname()[:2]
    return f"http://{f'[{host}]' if ':' in host else host}:{port}"


class Child:
    """Serves the run that was given last on a socket, which it takes over.

    Raises:
        LinkError: no process can be started.
    """

    def __init__(self, listener: socket.socket) -> None:
        number = listener.fileno()
        with listener:
            try:
                self._process = subprocess.Popen(
                    python_module("companion", "monitor", str(number)),
                    stdin=subprocess.PIPE,
                    stdout=subprocess.DEVNULL,
                    pass_fds=[number],
                    start_new_session=True,  # Ctrl-C is for the flight: its landing stays visible
                )
            except OSError as error:
                raise LinkError(f"the monitor cannot start: {error}") from error

    @property
    def is_running(self) -> bool:
        """Whether it still runs; it may end by itself."""
        return self._process.poll() is None

    def show(self, folder: Path) -> None:
        """Shows the run in a folder, which has its scene already."""
        pipe = self._process.stdin
        assert pipe is not None
        with contextlib.suppress(OSError):  # it has ended, and has reported that
            pipe.write(f"{folder.absolute()}\n".encode())
            pipe.flush()

    def close(self) -> None:
        """Ends it after browsers have received what is new. Does not wait."""
        assert self._process.stdin is not None
        with contextlib.suppress(OSError):
            self._process.stdin.close()

    def kill(self) -> None:
        """Kills it, so that its port is free again. Does not wait."""
        self._process.kill()
        self.close()
