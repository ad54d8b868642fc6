"""What a flight prints, and the signals that reach it.

The first Ctrl-C (or SIGTERM) holds, lands and ends the flight; the second one exits at once.
Nothing else that happens to a terminal affects the flight:

1. A line is written only if that needs no waiting. A stopped terminal (Ctrl-S), or a pager that
   does not read, delays the lines, which wait here, but not the flight.
2. A stream that cannot be written any more, such as a closed pipe or a full disk, is given up.
3. If the connection is lost (SIGHUP), the run's record says so. Suspending (Ctrl-Z) is ignored,
   because a suspended companion sends no setpoints.
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
from contextlib import closing, contextmanager
from types import FrameType
from typing import TYPE_CHECKING, TextIO

from companion.cli.times import minutes
from companion.errors import printable
from companion.flights.stopping import stopped_by
from companion.watchdog import Watchdog

if TYPE_CHECKING:
    from companion.app import Companion
    from companion.flight_events.event import Stamped

LINES_KEPT = 1000
"""Most lines that wait for a terminal that does not read; older ones are dropped."""
CLOSE_S = 2.0
"""How long the end of a command waits for a terminal that does not read."""
PIPE_BYTES = 4096
"""PIPE_BUF of Linux: a writable pipe takes at least this much without waiting."""


_SUSPENDING = (signal.SIGTSTP, signal.SIGTTOU, signal.SIGTTIN)


class Terminal:
    """Standard output and standard error, for lines that must not delay a flight; a `FrontEnd`.

    Lines may also come from a signal handler, or from a thread that draws a figure.
    """

    def __init__(self) -> None:
        self._writing = threading.Lock()
        self._waiting: deque[tuple[TextIO, str]] = deque(maxlen=LINES_KEPT)
        self._dead: set[TextIO] = set()

    def say(self, line: str, is_error: bool = False) -> None:
        """Prints a line now, or when the terminal accepts it; control characters are escaped."""
        self._waiting.append((sys.stderr if is_error else sys.stdout, printable(line)))
        self._write()

    def tell(self, stamped: Stamped) -> None:
        """Prints an event of a run."""
        self.say(f" {minutes(stamped.time_s)}  {stamped.event.text}")

    @contextmanager
    def attending(self, companion: Companion) -> Iterator[Callable[[], None]]:
        """While the context lasts, signals end the flight, and a service manager hears of it."""

        def promise() -> None:
            self.say("stopping: hold, land, exit; once more to exit at once", is_error=True)

        with (
            closing(Watchdog(os.environ)) as watchdog,
            stopped_by([signal.SIGINT, signal.SIGTERM], companion, promise),
            undisturbed(companion.hang_up),
        ):
            yield lambda: watchdog.beat(time.monotonic())

    def close(self) -> None:
        """Prints the waiting lines; drops those that cannot be printed."""
        end_s = time.monotonic() + CLOSE_S
        while self._waiting and time.monotonic() < end_s:
            self._write()
            if self._waiting:
                time.sleep(0.01)
        for stream in {stream for stream, _ in self._waiting} | self._dead:
            give_up(stream)

    def _write(self) -> None:
        """Writes what can be written, unless another call is doing so."""
        if not self._writing.acquire(blocking=False):
            return
        try:
            while self._waiting and self._is_done_with(*self._waiting[0]):
                self._waiting.popleft()
        finally:
            self._writing.release()

    def _is_done_with(self, stream: TextIO, line: str) -> bool:
        """Whether a line was written, or never can be."""
        if stream in self._dead:
            return True
        try:
            return write_at_once(stream, line + "\n")
        except (OSError, ValueError):  # ValueError: the stream is closed
            self._dead.add(stream)
            return True


def write_at_once(stream: TextIO, text: str) -> bool:
    """Writes a text if its stream accepts it without waiting; returns whether it did.

    Raises:
        OSError, ValueError: the stream accepts nothing any more.
    """
    try:
        number = stream.fileno()
    except OSError:  # there is no file behind it
        stream.write(text)
        return True
    stream.flush()
    data = text.encode(stream.encoding or "utf-8", errors="backslashreplace")
    for at in range(0, len(data), PIPE_BYTES):
        if not select.select([], [number], [], 0.0)[1]:
            return at > 0  # a text longer than the free part of the pipe is cut
        os.write(number, data[at : at + PIPE_BYTES])
    return True


def give_up(stream: TextIO) -> None:
    """Discards what is written from now on, also at the interpreter's exit."""
    try:
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, stream.fileno())
        os.close(nowhere)
    except (OSError, ValueError):
        return


@contextmanager
def undisturbed(hang_up: Callable[[], None]) -> Iterator[None]:
    """Keeps a terminal's signals from affecting the flight while the context lasts.

    Args:
        hang_up: called on SIGHUP.
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
