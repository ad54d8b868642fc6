"""Checks an uploaded mission in a child process that nobody waits for.

A door: it starts processes and reads their output. The flight process never parses what came from a
stranger; it only reads the JSON that its own child has printed, up to a size. A child checks one
mission and ends. Loading all modules takes it a second or two, so one child is kept ready.
"""

from __future__ import annotations

import json
import os
import subprocess
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Any, Protocol

from companion.python_child import python_module
from companion.skills.catalogue import Catalogue, as_json

MAX_OUTPUT_BYTES = 1 << 20  # of a child
MAX_TEXT = 2000  # characters of a result that are handed on
MAX_NOTICES = 20
CHILD = "companion.cli.check_child"
"""The module that a child runs; its docstring describes the input and the limits."""
_ONE_THREAD = {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1", "NO_COLOR": "1"}


@dataclass(frozen=True, slots=True)
class CheckResult:
    """The result of a check.

    Attributes:
        is_good: whether the mission can be flown.
        text: the plan, or what is wrong and where.
        notices: what is allowed, but probably not intended.
    """

    is_good: bool
    text: str
    notices: tuple[str, ...] = ()


class MissionCheck(Protocol):
    """A check under way."""

    def poll(self) -> CheckResult | None:
        """Returns the result once there is one; does not wait."""

    def kill(self) -> None:
        """Ends the check; the result follows."""


class CheckChildren:
    """Child processes that check one mission each; one is kept ready.

    If the one that is ready has died, it is replaced.

    Args:
        installed: functions of packages that a mission may call. A check loads none of them.
        hears_reports: whether reports of other programs are heard; if not, missions that need them
            get a notice.
    """

    def __init__(
        self, installed: Catalogue = MappingProxyType({}), hears_reports: bool = True
    ) -> None:
        self._spare = CheckChild()
        self._installed = as_json(installed)
        self._hears_reports = hears_reports

    def begin(self, folder: Path, mission: str) -> MissionCheck:
        """Begins the check of a mission; `Uploads` calls it.

        Args:
            folder: has all files; nothing else is read.
            mission: path in the folder.
        """
        child = self._spare if self._spare.is_running else CheckChild()
        child.order(folder, mission, self._installed, self._hears_reports)
        self._spare = CheckChild()
        return child

    def close(self) -> None:
        """Ends the child that is kept ready."""
        self._spare.close()


def begin_check(folder: Path, mission: str) -> MissionCheck:
    """Begins the check of a mission in a child process started for it."""
    child = CheckChild()
    child.order(folder, mission)
    return child


class CheckChild:
    """A child process that checks one mission; implements `MissionCheck`."""

    def __init__(self) -> None:
        self._child = subprocess.Popen(
            python_module(CHILD),
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            start_new_session=True,  # Ctrl-C in a terminal is for the flight process
            env=os.environ | _ONE_THREAD,
            bufsize=0,
        )
        assert self._child.stdin is not None and self._child.stdout is not None
        self._orders, self._answers = self._child.stdin, self._child.stdout
        os.set_blocking(self._answers.fileno(), False)
        self._printed = b""

    @property
    def is_running(self) -> bool:
        """Whether it has not ended."""
        return self._child.poll() is None

    def order(
        self,
        folder: Path,
        mission: str,
        installed: Sequence[dict[str, Any]] = (),
        hears_reports: bool = True,
    ) -> None:
        """Tells the child what to check, once. If it has just died, its result will say so."""
        with suppress(BrokenPipeError):
            order = json.dumps([str(folder), mission, [*installed], hears_reports])
            self._orders.write(order.encode() + b"\n")
        self._orders.close()

    def poll(self) -> CheckResult | None:
        """Reads the child's output; returns the result once the child has ended."""
        code = self._child.poll()
        while part := self._answers.read(MAX_OUTPUT_BYTES):
            self._printed += part
            if len(self._printed) > MAX_OUTPUT_BYTES:
                self.kill()
                self._printed = self._printed[:MAX_OUTPUT_BYTES]
                break
        if code is None:
            return None
        self._answers.close()
        return result_of(code, self._printed)

    def kill(self) -> None:
        """Ends the child process."""
        self._child.kill()

    def close(self) -> None:
        """Ends a child that is not needed any more."""
        self.kill()
        self._child.wait()
        self._orders.close()
        self._answers.close()


def result_of(code: int, printed: bytes) -> CheckResult:
    r"""Returns the result that a child has printed.

    Args:
        code: its exit code; negative for a signal.
        printed: its standard output: lines of JSON.

    >>> result_of(0, b'{"doing": "reading it"}\n{"ok": true, "plan": "move(A, B)"}\n')
    CheckResult(is_good=True, text='move(A, B)', notices=())
    >>> result_of(-9, b'{"doing": "reading it"}\n').text
    'the check was ended: it takes too much time or memory, for reading it'
    """
    said: list[Any] = []
    for line in printed.splitlines():
        with suppress(ValueError, RecursionError):
            said.append(json.loads(line))
    try:
        answer = said[-1]
        if "ok" in answer:
            is_good = code == 0 and answer["ok"] is True
            notices = [str(each)[:MAX_TEXT] for each in answer.get("notices", ())][:MAX_NOTICES]
            text = str(answer["plan" if is_good else "error"])[:MAX_TEXT]
            return CheckResult(is_good, text, tuple(notices))
        doing = f", for {str(answer['doing'])[:MAX_TEXT]}"
    except (IndexError, KeyError, TypeError):
        doing = ""
    if code < 0:
        return CheckResult(False, f"the check was ended: it takes too much time or memory{doing}")
    return CheckResult(False, f"the check has failed with exit code {code}{doing}")
