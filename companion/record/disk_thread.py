"""What a flight records is written by a thread: a disk may stand still, setpoints may not.

Writing waits for a file system that waits for its disk, also where nobody syncs. With a storage
card that stood still for 1.5 s now and then, a loop that wrote for itself was seen to send nothing
for 1.2 s; after one a PX4 leaves OFFBOARD.
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
        failure: why the newest that could not be written was not; None if all was.
    """

    def __init__(self) -> None:
        self.failure: str | None = None
        self._given_bytes = self._taken_bytes = 0
        self._queue: SimpleQueue[_Work | None] = SimpleQueue()
        self._thread = Thread(target=self._work, name="record", daemon=True)
        self._thread.start()

    @property
    def waiting_bytes(self) -> int:
        """What it was given and has not written yet."""
        return self._given_bytes - self._taken_bytes

    def append(self, file: IO[bytes], data: bytes) -> None:
        """Adds to an open file; others can read it as soon as that is done."""
        self._put(file, data)

    def write(self, path: Path, text: str) -> None:
        """Makes a file, or makes it anew."""
        self._put(path, text.encode("utf-8"))

    def close(self) -> None:
        """Ends when all is written."""
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
