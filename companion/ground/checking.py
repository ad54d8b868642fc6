"""Can an uploaded mission be flown? A child process answers; nobody waits for it.

A door: it starts processes and reads what they print. The flight process never parses what came
from a stranger; it reads the JSON that its own child has printed.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

from companion.ground import limited

MAX_TEXT = 2000  # characters of an answer that are handed on
_ONE_THREAD = {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1", "NO_COLOR": "1"}


@dataclass(frozen=True, slots=True)
class Answer:
    """What came out of a check.

    Attributes:
        text: the plan, or what is wrong and where.
    """

    is_good: bool
    text: str


class Check(Protocol):
    """A check under way."""

    def poll(self) -> Answer | None:
        """The answer, once there is one; does not wait."""

    def kill(self) -> None:
        """Ends it; the answer follows."""


class ChildCheck:
    """`companion check` on a mission in a folder of its own, as a child process.

    Args:
        folder: all files; nothing else is read.
        mission: path in the folder.
    """

    def __init__(self, folder: Path, mission: str) -> None:
        self._output = folder.with_name(folder.name + ".json")
        command = [sys.executable, "-m", limited.__name__, str(folder)]
        with self._output.open("wb") as output:
            self._child = subprocess.Popen(
                [*command, "check", "--json", "--within", ".", "--", mission],
                stdin=subprocess.DEVNULL,
                stdout=output,
                stderr=subprocess.DEVNULL,
                start_new_session=True,  # Ctrl-C in a terminal is for the flight process
                env=os.environ | _ONE_THREAD,
            )

    def poll(self) -> Answer | None:
        """See `Check`."""
        code = self._child.poll()
        if code is None:
            return None
        with self._output.open("rb") as output:
            printed = output.read(limited.MAX_OUTPUT_BYTES)
        self._output.unlink()
        return answer(code, printed)

    def kill(self) -> None:
        """See `Check`."""
        self._child.kill()


def answer(code: int, printed: bytes) -> Answer:
    """What a child has found out.

    Args:
        code: how it ended; negative is a signal.
        printed: on its standard output.

    >>> answer(0, b'{"ok": true, "plan": "move(A, B)"}')
    Answer(is_good=True, text='move(A, B)')
    >>> answer(-9, b'').text
    'the check needs too much time or memory'
    """
    try:
        said: Any = json.loads(printed)
        is_good = code == 0 and said["ok"] is True
        return Answer(is_good, str(said["plan" if is_good else "error"])[:MAX_TEXT])
    except (ValueError, KeyError, TypeError):
        if code < 0 or b"MemoryError" in printed:
            return Answer(False, "the check needs too much time or memory")
        return Answer(False, f"the check has failed with exit code {code}")
