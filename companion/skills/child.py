"""The program that runs one call of an installed function, and ends.

    python -P -m companion.skills.child GROUP NAME DESCRIPTOR PARENT

1. It confines itself, loads the function, reports that it is ready, and waits for the call on its
   standard input. Its answers go to the descriptor, as lines of JSON.
2. During a call, a thread sends a beat twice a second and receives messages. It ends the whole
   process group when no companion can send any more. `process.py` is the other side.
3. It is no sandbox: an installed function is trusted like the program itself. It has limited
   memory, a low priority, only two descriptors of the companion's, and ends with the companion.
"""

from __future__ import annotations

import ctypes
import faulthandler
import os
import select
import signal
import sys
import threading
import traceback
from collections.abc import Callable, Iterator
from contextlib import suppress
from itertools import islice
from queue import SimpleQueue
from typing import Any

from companion.python_child import MIB, confine_memory
from companion.skills.authoring import (
    Cancelled,
    FunctionKind,
    FunctionRun,
    KnownPlace,
    KnownVehicle,
    SkillFailure,
    WaypointEnu,
)
from companion.skills.calls import MAX_TEXT, MAX_WAYPOINTS, Function
from companion.skills.lines import LineReader, Malformed, line_of
from companion.skills.loading import Unusable, in_words, loaded

MEMORY_MIB = 2048
NICENESS = 10
BEAT_S = 0.5
PR_SET_PDEATHSIG = 1
OUT_OF_MEMORY_FIRST = "1000"
"""When memory is short, the system kills this process before the companion."""

Message = dict[str, Any]


class Channel:
    """Both directions of the connection; implements `authoring.Interlocutor`.

    Args:
        orders: descriptor from which this process reads its messages.
        answers: descriptor to which it writes.
    """

    def __init__(self, orders: int, answers: int) -> None:
        self._orders, self._answers = orders, answers
        self._writing, self._asking = threading.Lock(), threading.Lock()
        self._calls: SimpleQueue[Message] = SimpleQueue()
        self._replies: SimpleQueue[Message | None] = SimpleQueue()
        self._is_called = self._is_cancelled = False

    def listen(self) -> None:
        """Starts to receive, and to send beats."""
        threading.Thread(target=self._listen, name="companion", daemon=True).start()

    def call(self) -> Message:
        """Waits for the call."""
        return self._calls.get()

    def say(self, message: Message) -> None:
        """Sends a message; if no companion can receive it, ends the process."""
        line = line_of(message)
        with self._writing:
            try:
                while line:
                    line = line[os.write(self._answers, line) :]
            except OSError:
                end_group()

    # -- authoring.Interlocutor ----------------------------------------------------------------

    def progress(self, share: float | None, text: str) -> None:
        """Reports progress."""
        self._go_on()
        self.say({"is": "progress", "share": share, "text": text[:MAX_TEXT]})

    def sleep(self, seconds: float) -> None:
        """Returns after this much time of the flight."""
        self._ask({"is": "sleep", "seconds": seconds})

    def command(self, component: str | int, command: str, parameters: tuple[float, ...]) -> None:
        """Returns when the payload has done it."""
        asked = {"component": component, "command": command, "parameters": parameters}
        reply = self._ask({"is": "command", **asked})
        if reply["failure"] is not None:
            raise SkillFailure(reply["failure"])

    @property
    def is_cancelled(self) -> bool:
        """Whether the result of the call is not awaited any more."""
        return self._is_cancelled

    # ------------------------------------------------------------------------------------------

    def _ask(self, message: Message) -> Message:
        with self._asking:
            self._go_on()
            self.say(message)
            reply = self._replies.get()
            if reply is None:
                raise Cancelled
            return reply

    def _go_on(self) -> None:
        if self._is_cancelled:
            raise Cancelled

    def _listen(self) -> None:
        reader = LineReader()
        with suppress(OSError, Malformed):
            while True:
                if not select.select([self._orders], [], [], BEAT_S)[0]:
                    if self._is_called:
                        self.say({"is": "beat"})
                    continue
                part = os.read(self._orders, 1 << 16)
                if not part:
                    break
                for message in reader.take(part):
                    self._take(message)
        end_group()

    def _take(self, message: Message) -> None:
        match message["is"]:
            case "call":
                self._is_called = True
                self._calls.put(message)
            case "reply":
                self._replies.put(message)
            case "cancel":
                self._is_cancelled = True
                self._replies.put(None)


def end_group() -> None:
    """Ends this process and all that it has started."""
    if os.getpgrp() == os.getpid():
        os.killpg(0, signal.SIGKILL)
    os._exit(1)


def outcome(
    function: Callable[..., Any], kind: FunctionKind, message: Message, run: FunctionRun
) -> Message:
    """The result of a call, in JSON values."""
    arguments, keywords = message["arguments"], message["keywords"]
    place, waypoints, verdicts = run.places.get(message["place"]), [], []
    try:
        match kind:
            case FunctionKind.SKILL:
                if function(run, *arguments, **keywords) is False:
                    raise SkillFailure(
                        "it returned False; a skill that has failed raises Failed(text)"
                    )
            case FunctionKind.SUGGESTER:
                found = function(run, place, *arguments, **keywords)
                waypoints = [*_waypoints(found)]
            case FunctionKind.PLACE_TEST:
                for written in message["waypoints"]:
                    verdict = function(run, place, WaypointEnu(*written), *arguments, **keywords)
                    if not isinstance(verdict, bool):
                        raise SkillFailure(f"it returned {verdict!r}, neither True nor False")
                    verdicts.append(verdict)
    except Cancelled:
        return _failed("cancelled")
    except SkillFailure as failed:
        return _failed(str(failed).strip() or "Failed, without a word")
    except MemoryError:
        return _failed(f"MemoryError: it may use {MEMORY_MIB} MiB")
    except BaseException as error:  # whatever foreign code raises, even SystemExit
        traceback.print_exc()
        return _failed(in_words(error))
    return {"is": "returned", "waypoints": waypoints, "verdicts": verdicts}


def _failed(text: str) -> Message:
    return {"is": "failed", "text": text[:MAX_TEXT]}


def _waypoints(found: Any) -> Iterator[list[float | None]]:
    for each in islice(found or (), MAX_WAYPOINTS):
        if not isinstance(each, tuple) or not 2 <= len(each) <= 3:
            raise SkillFailure(f"it proposes {each!r}; write Waypoint(east_m, north_m)")
        east_m, north_m, up_m = WaypointEnu(*each)
        yield [float(east_m), float(north_m), None if up_m is None else float(up_m)]


def main() -> None:
    """Entry point."""
    group, name, descriptor, parent = sys.argv[1:]
    function = Function(FunctionKind(group), name)
    channel = Channel(_standard_input(), int(descriptor))
    os.set_inheritable(int(descriptor), False)
    _tie_to(int(parent))
    _confine()
    channel.listen()
    try:
        found = loaded(function)
    except Unusable as unusable:
        channel.say(_failed(str(unusable)))
        return
    channel.say({"is": "ready"})
    message = channel.call()
    os.chdir(message["folder"])  # no module is imported from there
    places = {place["name"]: KnownPlace(**place) for place in message["places"]}
    vehicle = message["vehicle"]
    run = FunctionRun(channel, places, None if vehicle is None else KnownVehicle(**vehicle))
    said = outcome(found, function.kind, message, run)
    for stream in (sys.stdout, sys.stderr):
        with suppress(OSError, ValueError):
            stream.flush()
    channel.say(said)


def _standard_input() -> int:
    """A duplicate of it that children do not inherit; standard input itself becomes empty."""
    orders = os.dup(0)
    nothing = os.open(os.devnull, os.O_RDONLY)
    os.dup2(nothing, 0)
    os.close(nothing)
    return orders


def _tie_to(parent: int) -> None:
    """Makes this process end with the companion, whatever either does."""
    with suppress(OSError, AttributeError):
        ctypes.CDLL(None, use_errno=True).prctl(PR_SET_PDEATHSIG, signal.SIGKILL)
    if os.getppid() != parent:
        end_group()


def _confine() -> None:
    faulthandler.enable()
    os.nice(NICENESS)
    with suppress(OSError), open("/proc/self/oom_score_adj", "w") as score:
        score.write(OUT_OF_MEMORY_FIRST)
    confine_memory(MEMORY_MIB * MIB)
    for stream in (sys.stdout, sys.stderr):
        stream.reconfigure(line_buffering=True)  # type: ignore[union-attr]


if __name__ == "__main__":
    main()
