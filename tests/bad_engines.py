"""Engines that do what they should not, in the process of `companion.planning.engine_process`."""

from __future__ import annotations

import os
import signal
from functools import partial
from typing import Any, NoReturn

from companion.planning import engine_process
from companion.planning.compilation.classical import ClassicalProblem

_run = engine_process.run


class TooLarge(engine_process.EngineQuestion):
    """A task that no memory can hold when it is compiled."""

    def compiled(self) -> ClassicalProblem:
        _Eating().solve(self)


class _Bad:
    """What unified-planning calls an engine, as far as the child asks."""

    def supports(self, kind: object) -> bool:
        return True

    def solve(self, task: object) -> NoReturn:
        raise NotImplementedError


class _Killed(_Bad):
    def solve(self, task: object) -> NoReturn:
        os.kill(os.getpid(), signal.SIGKILL)
        raise AssertionError


class _Eating(_Bad):
    def solve(self, task: object) -> NoReturn:
        eaten: list[bytes] = []
        while True:
            eaten.append(b"x" * (1 << 20))


class _Spinning(_Bad):
    def solve(self, task: object) -> NoReturn:
        while True:
            pass


class _Deaf(_Bad):
    """As a library in C may be: no signal that can be blocked reaches it."""

    def solve(self, task: object) -> NoReturn:
        signal.pthread_sigmask(signal.SIG_BLOCK, signal.valid_signals())
        while True:
            pass


def _with(kind: type[_Bad], /, *arguments: Any, **named: Any) -> None:
    engine_process._planner = lambda engine, parameters: kind()
    _run(*arguments, **named)


killed, eating, spinning, deaf = (partial(_with, e) for e in (_Killed, _Eating, _Spinning, _Deaf))
