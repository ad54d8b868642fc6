"""What a flight prints, and the signals of the terminal that it was started from.

Nothing that happens to a terminal reaches the flight:

1. A line is written if that can be done at once. A terminal that was stopped (Ctrl-S), or a pager
   that does not read, holds up the lines, which wait here, and not the flight.
2. A stream that cannot be written any more, as a closed pipe or a full disk, is given up.
3. The connection may go (SIGHUP): that is told in the run's record. Suspending (Ctrl-Z) is ignored,
   as a suspended companion sends no setpoints.
"""

from __future__ import annotations

import os
import select
import signal
import sys
import threading
import time
from collections import deque
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType
from typing import TextIO

from companion.errors import printable

LINES_KEPT = 1000
"""So many lines wait for a terminal that does not read; older ones are dropped."""
CLOSE_S = 2.0
"""How long the end of a command waits for a terminal that does not read."""
PIPE_BYTES = 4096
"""PIPE_BUF of Linux: a pipe that can be written to takes as much without waiting."""


_SUSPENDING = (signal.SIGTSTP, signal.SIGTTOU, signal.SIGTTIN)


class Terminal:
    """Standard output and standard error, for lines that may not hold up a flight.

    A line may also come from a signal handler, or from a thread that draws a figure.
    """

    def __init__(self) -> None:
        self._writing = threading.Lock()
        self._waiting: deque[tuple[TextIO, str]] = deque(maxlen=LINES_KEPT)
        self._dead: set[TextIO] = set()

    def say(self, line: str, is_error: bool = False) -> None:
        """Prints a line now, or when the terminal takes it; it obeys none of its characters."""
        self._waiting.append((sys.stderr if is_error else sys.stdout, printable(line)))
        self._write()

    def close(self) -> None:
        """Prints what still waits, and gives up what cannot be printed."""
        end_s = time.monotonic() + CLOSE_S
        while self._waiting and time.monotonic() < end_s:
            self._write()
            if self._waiting:
                time.sleep(0.01)
        for stream in {stream for stream, _ in self._waiting} | self._dead:
            give_up(stream)

    def _write(self) -> None:
        """Writes what can be written, unless somebody else is at it."""
        if not self._writing.acquire(blocking=False):
            return
        try:
            while self._waiting and self._is_done_with(*self._waiting[0]):
                self._waiting.popleft()
        finally:
            self._writing.release()

    def _is_done_with(self, stream: TextIO, line: str) -> bool:
        """Whether a line was written, or never will be."""
        if stream in self._dead:
            return True
        try:
            return write_at_once(stream, line + "\n")
        except (OSError, ValueError):  # ValueError: the stream was closed
            self._dead.add(stream)
            return True


def write_at_once(stream: TextIO, text: str) -> bool:
    """Writes a text if its stream takes it without waiting; returns whether it did.

    Raises:
        OSError, ValueError: the stream takes nothing any more.
    """
    try:
        number = stream.fileno()
    except OSError:  # no file behind it
        stream.write(text)
        return True
    stream.flush()
    data = text.encode(stream.encoding or "utf-8", errors="backslashreplace")
    for at in range(0, len(data), PIPE_BYTES):
        if not select.select([], [number], [], 0.0)[1]:
            return at > 0  # a text longer than the pipe's room is cut
        os.write(number, data[at : at + PIPE_BYTES])
    return True


def give_up(stream: TextIO) -> None:
    """Sends to nowhere what is written from now on, at the interpreter's end as well."""
    try:
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, stream.fileno())
        os.close(nowhere)
    except (OSError, ValueError):
        return


@contextmanager
def undisturbed(hang_up: Callable[[], None]) -> Iterator[None]:
    """Keeps the signals of a terminal from the flight for as long as the context lasts.

    Args:
        hang_up: is told of SIGHUP.
    """

    def note(number: int, frame: FrameType | None) -> None:
        hang_up()

    before = {number: signal.signal(number, signal.SIG_IGN) for number in _SUSPENDING}
    before[signal.SIGHUP] = signal.signal(signal.SIGHUP, note)
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
