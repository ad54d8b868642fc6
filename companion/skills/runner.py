"""Runs the functions that a mission calls: one process per call, started beforehand, with limits.

1. A door. Before the flight, a process is started for each function that the mission calls, and
   loads it. A call takes this process, and another one is started for the next call.
2. In each tick the flight asks what a call has said. This never waits, and reads a limited amount.
3. In lockstep, simulated time waits instead, until the function sleeps, waits for a reply, or has
   ended. So a call takes exactly the simulated time that it sleeps (`run.sleep`), and equal flights
   have equal events on any machine.
4. Times here are real, by the monotonic clock, except sleeps, which are by the flight's clock.
"""

from __future__ import annotations

import shutil
import tempfile
import threading
import time
from collections import deque
from collections.abc import Iterable
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from companion.errors import CompanionError
from companion.outcomes import Failed
from companion.skills.calls import Answer, CallRequest, CommandAsked, Function, Returned, answer_of
from companion.skills.lines import Malformed
from companion.skills.process import FunctionProcess, in_words

READY_S = 60.0
"""Time within which a function must be loaded."""
SILENT_S = 10.0
"""A process that is silent this long hangs; it sends a beat twice a second."""
SILENT_IN_LOCKSTEP_S = 60.0
ANSWERS_IN_LOCKSTEP_S = 600.0
"""A simulated flight that waits longer than this for a function is ended."""
ASKED_LATELY_S = 2.0
MESSAGES = 200
"""Most messages of a call in a tick."""
FOLDER = "skills"
"""In the run folder: a folder for each call, in which it runs and its output is kept."""
_INSTANT_S = 1e-6


@dataclass
class _Call:
    """A call under way.

    Attributes:
        until_s: end of its sleep, by the flight's clock; None while it does not sleep.
        is_asking: it waits for the reply to a command.
        asked_s: when the flight last asked for news.
    """

    process: FunctionProcess
    is_ready: bool
    asked_s: float
    until_s: float | None = None
    is_asking: bool = False
    inbox: deque[dict[str, Any]] = field(default_factory=deque)


class FunctionRunner:
    """Implements `acting.function_port.FunctionPort`.

    Args:
        folder: the folder of the run; without one, calls run in a folder that is removed.
        is_lockstep: simulated time waits for functions.

    Attributes:
        folder: where further calls have their folders; written by the owner.
    """

    def __init__(self, folder: Path | None = None, is_lockstep: bool = False) -> None:
        self.folder = folder
        self._is_lockstep = is_lockstep
        self._spares: dict[Function, FunctionProcess] = {}
        self._endings: list[threading.Thread] = []
        self._not_begun: dict[int, Failed] = {}
        self._ready: set[FunctionProcess] = set()
        self._calls: dict[int, _Call] = {}
        self._tickets = 0
        self._temporary: Path | None = None

    def prepare(self, functions: Iterable[Function]) -> None:
        """Starts to load functions; all others are unloaded."""
        wanted = dict.fromkeys(functions)
        for function in [each for each in self._spares if each not in wanted]:
            self._drop(function)
        for function in wanted:
            self._prepare(function)

    def awaited(self) -> tuple[str, ...] | Failed:
        """The functions that are still being loaded, or why one cannot be loaded."""
        waiting = []
        for function, process in self._spares.items():
            process.unusable = process.unusable or self._failure_to_load(process)
            if process.unusable is not None:
                return Failed(f"{function.name}: {process.unusable}")
            if process not in self._ready:
                waiting.append(function.name)
        return tuple(waiting)

    def begin(self, request: CallRequest) -> int:
        """Begins a call and returns its ticket; starts another process for the next call."""
        function = request.call.function
        self._tickets += 1
        self._prepare(function)
        if (process := self._spares.pop(function, None)) is None:
            self._not_begun[self._tickets] = Failed("no process can be started for it")
            return self._tickets
        self._prepare(function)
        folder = self._folder_of(function)
        if folder is not None:
            process.print_to(folder)
        process.say({"is": "call", "folder": str(folder or "/"), **request.as_json()})
        now_s = time.monotonic()
        is_ready = process in self._ready
        self._ready.discard(process)
        process.heard_s = now_s
        self._calls[self._tickets] = _Call(process, is_ready, now_s)
        return self._tickets

    def take(self, ticket: int, now_s: float) -> list[Answer]:
        """What a call has said since the last time; after the last answer it is over.

        Args:
            now_s: by the flight's clock.

        Raises:
            CompanionError: in lockstep, the function has said nothing for minutes.
        """
        if ticket in self._not_begun:
            return [self._not_begun.pop(ticket)]
        call = self._calls[ticket]
        answers: list[Answer] = []
        for _ in range(MESSAGES):
            if call.is_asking or (call.until_s is not None and now_s + _INSTANT_S < call.until_s):
                self._look_after(call, answers)
                break
            if call.until_s is not None:
                call.until_s = None
                call.process.say({"is": "reply"})
            message = self._next(call)
            if message is None:
                self._look_after(call, answers)
                break
            self._take(call, message, now_s, answers)
            if answers and isinstance(answers[-1], Returned | Failed):
                break
        call.asked_s = time.monotonic()
        if answers and isinstance(answers[-1], Returned | Failed):
            self.cancel(ticket)
        return answers

    def reply(self, ticket: int, failure: str | None) -> None:
        """Passes on the result of the command that a call asked for; None if it was done."""
        call = self._calls[ticket]
        call.is_asking = False
        call.process.say({"is": "reply", "failure": failure})

    def cancel(self, ticket: int) -> None:
        """Ends a call whose result is not awaited any more."""
        call = self._calls.pop(ticket, None)
        if call is not None:
            self._endings = [each for each in self._endings if each.is_alive()]
            self._endings.append(call.process.end())

    def end_calls(self) -> None:
        """Ends all calls; loaded functions stay loaded."""
        for ticket in list(self._calls):
            self.cancel(ticket)

    def close(self) -> None:
        """Ends all processes."""
        for call in self._calls.values():
            call.process.kill()
        self._calls.clear()
        for function in list(self._spares):
            self._drop(function)
        for ending in self._endings:
            ending.join()
        if self._temporary is not None:
            shutil.rmtree(self._temporary, ignore_errors=True)

    # ------------------------------------------------------------------------------------------

    def _prepare(self, function: Function) -> None:
        """Starts a process for the next call, if the system allows it."""
        spare = self._spares.get(function)
        if spare is not None and (spare.unusable or spare.exit_code is not None):
            self._drop(function)
        if function not in self._spares:
            with suppress(OSError):
                self._spares[function] = FunctionProcess(function)

    def _drop(self, function: Function) -> None:
        process = self._spares.pop(function)
        self._ready.discard(process)
        process.kill()

    def _folder_of(self, function: Function) -> Path | None:
        """A folder for a call; None if there can be none: a full disk ends no flight."""
        if self.folder is None and self._temporary is None:
            with suppress(OSError):
                self._temporary = Path(tempfile.mkdtemp(prefix="companion-"))
        root = self.folder / FOLDER if self.folder is not None else self._temporary
        if root is None:
            return None
        number = self._tickets
        while True:
            folder = root / f"{number}-{function.name}"
            try:
                folder.mkdir(parents=True)
                return folder.resolve()
            except FileExistsError:  # of a run that was cut off
                number += 1
            except OSError:
                return None

    def _failure_to_load(self, process: FunctionProcess) -> str | None:
        """Why a function cannot be loaded, None if it can; in lockstep, waits until known."""
        if process in self._ready:
            return None
        while True:
            for message in process.hear():
                if message.get("is") == "ready":
                    self._ready.add(process)
                    return None
                return str(message.get("text"))
            if (code := process.exit_code) is not None:
                return in_words(code)
            if time.monotonic() - process.begun_s > READY_S:
                return f"it is not loaded after {READY_S:.0f} s"
            if not self._is_lockstep:
                return None
            process.wait(0.1)

    def _next(self, call: _Call) -> dict[str, Any] | None:
        """The next message of a call; None if there is none yet, or none will follow."""
        begun_s = time.monotonic()
        while not call.inbox:
            call.inbox += call.process.hear()
            if call.inbox:
                break
            if not self._is_lockstep or self._why_not_heard(call) is not None:
                return None
            if time.monotonic() - begun_s > ANSWERS_IN_LOCKSTEP_S:
                raise CompanionError(
                    f"a skill has said nothing for {ANSWERS_IN_LOCKSTEP_S:.0f} s of real time, and "
                    "simulated time waits for it\n    let it wait by run.sleep(seconds)"
                )
            call.process.wait(0.1)
            call.asked_s = time.monotonic()
        return call.inbox.popleft()

    def _take(
        self, call: _Call, message: dict[str, Any], now_s: float, answers: list[Answer]
    ) -> None:
        try:
            match message.get("is"):
                case "ready":
                    call.is_ready = True
                case "sleep":
                    call.until_s = now_s + float(message["seconds"])
                case _:
                    answer = answer_of(message)
                    call.is_asking = isinstance(answer, CommandAsked)
                    answers.append(answer)
        except (Malformed, KeyError, TypeError, ValueError):
            call.process.is_broken = True

    def _look_after(self, call: _Call, answers: list[Answer]) -> None:
        """Detects that nothing more will be heard of a call, and why."""
        if len(call.inbox) < MESSAGES:
            call.inbox += call.process.hear()
        if not call.inbox and (reason := self._why_not_heard(call)) is not None:
            call.inbox += call.process.hear()  # said since the last look
            if not call.inbox:
                answers.append(Failed(reason))

    def _why_not_heard(self, call: _Call) -> str | None:
        process, now_s = call.process, time.monotonic()
        if process.is_broken:
            return "its process has sent something that is not a message"
        if (code := process.exit_code) is not None:
            return in_words(code)
        if not call.is_ready:
            late = now_s - process.begun_s > READY_S
            return f"it is not loaded after {READY_S:.0f} s" if late else None
        most_s = SILENT_IN_LOCKSTEP_S if self._is_lockstep else SILENT_S
        if now_s - call.asked_s > ASKED_LATELY_S:
            return None  # the flight itself was late to look; first it has to listen
        hangs = now_s - process.heard_s > most_s
        return f"its process hangs: not heard for {most_s:.0f} s" if hangs else None
