"""Writes the records of a flight in a thread, because a disk may stall but setpoints must not.

Even without a sync, writing may wait for a file system that waits for its disk. A storage card that
stalled for 1.5 s now and then made a loop that wrote itself send nothing for 1.2 s; after 1 s, PX4
leaves OFFBOARD.
"""

from __future__ import annotations

from pathlib import Path
from queue import SimpleQueue
from threading import Thread
from typing import IO

_Work = tuple[IO[bytes] | Path, bytes]


class DiskThread:
    """Writes what it is given, in that order.

    Attributes:
        failure: why the latest failed write failed; None if there was none.
    """

    def __init__(self) -> None:
        self.failure: str | None = None
        self._given_bytes = self._taken_bytes = 0
        self._queue: SimpleQueue[_Work | None] = SimpleQueue()
        self._thread = Thread(target=self._work, name="record", daemon=True)
        self._thread.start()

    @property
    def waiting_bytes(self) -> int:
        """The number of bytes that are not written yet."""
        return self._given_bytes - self._taken_bytes

    def append(self, file: IO[bytes], data: bytes) -> None:
        """Appends to an open file; afterwards other programs can read the data."""
        self._put(file, data)

    def write(self, path: Path, text: str) -> None:
        """Writes a file anew."""
        self._put(path, text.encode("utf-8"))

    def close(self) -> None:
        """Ends when everything is written."""
        self._queue.put(None)
        self._thread.join()

    def _put(self, to: IO[bytes] | Path, data: bytes) -> None:
        self._given_bytes += len(data)
        self._queue.put((to, data))

    def _work(self) -> None:
        while (work := self._queue.get()) is not None:
            to, data = work
            try:
                if isinstance(to, Path):
                    to.write_bytes(data)
                else:
                    to.write(data)
                    to.flush()
            except OSError as error:
                self.failure = error.strerror or str(error)
            self._taken_bytes += len(data)
