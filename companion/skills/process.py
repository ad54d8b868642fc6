"""A function's process, on the companion's side: starts it, talks to it, and ends it.

A door: it starts a process, and reads and writes its pipes. Only `wait` waits, for simulated
flights. Nothing that a process says or does raises an exception here. `child.py` is the other side.
"""

from __future__ import annotations

import os
import select
import signal
import subprocess
import threading
import time
from contextlib import suppress
from pathlib import Path
from typing import IO, Any

from companion.python_child import python_module
from companion.skills.calls import Function
from companion.skills.lines import LineReader, Malformed, line_of

OUTPUT = "output.txt"
PROGRAM = "companion.skills.child"
READ_BYTES = 1 << 15
"""Most bytes of messages, and of printed output, that are read at once."""
OUTPUT_BYTES = 256 << 10
"""Most bytes of printed output that are kept."""
LEFT_OUT = b"\n... the rest is left out\n"
TERMINATE_S, KILL_S = 1.0, 2.0
"""A process that was told to end gets SIGTERM, then SIGKILL, after these times."""
_OF_THE_COMPANION = ("NOTIFY_SOCKET", "WATCHDOG_USEC", "WATCHDOG_PID")
"""The service manager expects these only from the companion."""


class FunctionProcess:
    """A process that loads a function and runs one call of it.

    Attributes:
        begun_s: start, by the monotonic clock.
        heard_s: when it was last heard.
        is_broken: it has sent something that is no message.
        unusable: why its function cannot be called; None while it can. Written by the owner.
    """

    def __init__(self, function: Function) -> None:
        self.begun_s = self.heard_s = time.monotonic()
        self.is_broken = False
        self.unusable: str | None = None
        self._reader = LineReader()
        answers, theirs = os.pipe()
        kind, name = function.kind.value, function.name
        try:
            self._child = subprocess.Popen(
                python_module(PROGRAM, kind, name, str(theirs), str(os.getpid())),
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=subprocess.STDOUT,
                pass_fds=(theirs,),
                start_new_session=True,
                env={k: v for k, v in os.environ.items() if k not in _OF_THE_COMPANION},
                bufsize=0,
            )
        except BaseException:
            os.close(answers)
            raise
        finally:
            os.close(theirs)
        self._answers = answers
        self._pipes = [self._child.stdin, self._child.stdout]
        for descriptor in (answers, *(pipe.fileno() for pipe in self._pipes if pipe)):
            os.set_blocking(descriptor, False)
        self._folder: Path | None = None
        self._output: IO[bytes] | None = None
        self._prints_no_more = False
        self._printed, self._kept_bytes, self._is_cut = b"", 0, False

    @property
    def exit_code(self) -> int | None:
        """How it has ended, negative for a signal; None while it runs.

        The process is not reaped yet: its number stays reserved until its group is ended.
        """
        ended = os.waitid(os.P_PID, self._child.pid, os.WEXITED | os.WNOHANG | os.WNOWAIT)
        if ended is None:
            return None
        return ended.si_status if ended.si_code == os.CLD_EXITED else -ended.si_status

    def print_to(self, folder: Path) -> None:
        """Directs what it prints to a file in a folder; a folder that stays empty is removed."""
        self._folder = folder

    def say(self, message: dict[str, Any]) -> None:
        """Sends a message; a process that has ended or does not read is found later."""
        stdin = self._child.stdin
        assert stdin is not None
        try:
            line = line_of(message)
            self.is_broken |= stdin.write(line) != len(line)
        except Malformed:
            self.is_broken = True
        except OSError:
            return

    def hear(self) -> list[dict[str, Any]]:
        """Its messages since the last call, without its beats."""
        self._take_output()
        try:
            part = os.read(self._answers, READ_BYTES)
        except BlockingIOError:
            return []
        except OSError:
            part = b""
        if not part:
            return []
        self.heard_s = time.monotonic()
        try:
            return [each for each in self._reader.take(part) if each.get("is") != "beat"]
        except Malformed:
            self.is_broken = True
            return []

    def wait(self, timeout_s: float) -> None:
        """Waits until it sends or prints something, or has ended."""
        descriptors = [self._answers]
        if self._child.stdout is not None and not self._prints_no_more:
            descriptors.append(self._child.stdout.fileno())
        select.select(descriptors, [], [], timeout_s)

    def end(self) -> threading.Thread:
        """Tells it to end; a thread makes sure that it does, and closes everything."""
        self.say({"is": "cancel"})
        ending = threading.Thread(target=self._see_to_the_end, name="end of a call", daemon=True)
        ending.start()
        return ending

    def kill(self) -> None:
        """Kills it and all that it has started."""
        self._signal(signal.SIGKILL)
        self._child.wait()
        self._take_output()
        self._close()

    def _see_to_the_end(self) -> None:
        begun_s, is_told = time.monotonic(), False
        while self.exit_code is None and (left_s := begun_s + KILL_S - time.monotonic()) > 0:
            if left_s < KILL_S - TERMINATE_S and not is_told:
                self._signal(signal.SIGTERM)
                is_told = True
            self._take_output()
            time.sleep(0.02)
        self.kill()  # and what it has left running

    def _signal(self, number: signal.Signals) -> None:
        with suppress(ProcessLookupError, PermissionError):
            os.killpg(self._child.pid, number)

    def _take_output(self) -> None:
        stdout = self._child.stdout
        assert stdout is not None
        with suppress(OSError, ValueError):
            printed = stdout.read(READ_BYTES)
            self._prints_no_more = printed == b""
            self._keep(printed or b"")

    def _keep(self, printed: bytes) -> None:
        """Keeps the beginning of the printed output; before a call begins, in memory."""
        room = max(0, OUTPUT_BYTES - self._kept_bytes - len(self._printed))
        self._printed += printed[:room]
        if len(printed) > room and not self._is_cut:
            self._is_cut = True
            self._printed += LEFT_OUT
        if self._folder is not None and self._printed:
            if self._output is None:
                self._output = (self._folder / OUTPUT).open("ab", buffering=0)
            self._kept_bytes += len(self._printed)
            self._output.write(self._printed)
            self._printed = b""

    def _close(self) -> None:
        with suppress(OSError):
            os.close(self._answers)
        for pipe in (*self._pipes, self._output):
            if pipe is not None:
                with suppress(OSError):
                    pipe.close()
        if self._folder is not None:
            with suppress(OSError):
                self._folder.rmdir()


def in_words(exit_code: int) -> str:
    """Why a process has ended without saying so.

    >>> in_words(3), in_words(-11)
    ('its process ended with exit code 3', 'its process was ended by SIGSEGV')
    """
    if exit_code >= 0:
        return f"its process ended with exit code {exit_code}"
    try:
        name = signal.Signals(-exit_code).name
    except ValueError:
        name = f"signal {-exit_code}"
    hint = ", perhaps for want of memory" if exit_code == -signal.SIGKILL else ""
    return f"its process was ended by {name}{hint}"
