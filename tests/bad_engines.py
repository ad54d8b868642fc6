"""Engines that do what they should not, in the child process of `companion.planning.engines`."""

from __future__ import annotations

import os
import signal
from functools import partial
from typing import Any, NoReturn

from companion.planning import engines

_child = engines._child


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


def _with(engine: type[_Bad], *arguments: Any) -> None:
    engines._planner = lambda name, setup: engine()
    _child(*arguments)


killed, eating, spinning, deaf = (partial(_with, e) for e in (_Killed, _Eating, _Spinning, _Deaf))
