"""The check of an uploaded mission: `companion check` in a child process that nobody waits for.

A door: it starts processes and reads what they print. The flight process never parses what came
from a stranger; it reads the JSON that its own child has printed.
"""

from __future__ import annotations

import json
import os
import subprocess
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

from companion.ground import limited
from companion.python_child import python_module

MAX_TEXT = 2000  # characters of a result that are handed on
_ONE_THREAD = {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1", "NO_COLOR": "1"}


@dataclass(frozen=True, slots=True)
class CheckResult:
    """The result of a check.

    Attributes:
        is_good: whether the mission can be flown.
        text: the plan, or what is wrong and where.
    """

    is_good: bool
    text: str


class MissionCheck(Protocol):
    """A check under way."""

    def poll(self) -> CheckResult | None:
        """Returns the result once there is one; does not wait."""

    def kill(self) -> None:
        """Ends it; the result follows."""


class ChildCheck:
    """`companion check` on a mission in a folder of its own, as a child process.

    Args:
        folder: all files; nothing else is read.
        mission: path in the folder.
    """

    def __init__(self, folder: Path, mission: str) -> None:
        self._output = folder.with_name(folder.name + ".json")
        command = python_module(limited.__name__, str(folder))
        with self._output.open("wb") as output:
            self._child = subprocess.Popen(
                [*command, "check", "--json", "--within", ".", "--", mission],
                stdin=subprocess.DEVNULL,
                stdout=output,
                stderr=subprocess.DEVNULL,
                start_new_session=True,  # Ctrl-C in a terminal is for the flight process
                env=os.environ | _ONE_THREAD,
            )

    def poll(self) -> CheckResult | None:
        """Reads what the child has printed once it has ended."""
        code = self._child.poll()
        if code is None:
            return None
        with self._output.open("rb") as output:
            printed = output.read(limited.MAX_OUTPUT_BYTES)
        self._output.unlink()
        return result_of(code, printed)

    def kill(self) -> None:
        """Ends the child process."""
        self._child.kill()


def result_of(code: int, printed: bytes) -> CheckResult:
    """Returns what a child has found out.

    Args:
        code: how it ended; negative is a signal.
        printed: on its standard output.

    >>> result_of(0, b'{"ok": true, "plan": "move(A, B)"}')
    CheckResult(is_good=True, text='move(A, B)')
    >>> result_of(-9, b'').text
    'the check needs too much time or memory'
    """
    try:
        said: Any = json.loads(printed)
        is_good = code == 0 and said["ok"] is True
        return CheckResult(is_good, str(said["plan" if is_good else "error"])[:MAX_TEXT])
    except (ValueError, KeyError, TypeError):
        if code < 0 or b"MemoryError" in printed:
            return CheckResult(False, "the check needs too much time or memory")
        return CheckResult(False, f"the check has failed with exit code {code}")
