"""What a worker process does: it unpacks a kit once, and flies rows.

Nothing that a row does ends the campaign: what raises is the outcome `error`. A worker whose
environment is not that of the kit flies nothing, and says what differs.
"""

from __future__ import annotations

import gc
import multiprocessing
import os
import platform
import signal
import threading
import traceback
from dataclasses import dataclass
from functools import lru_cache
from multiprocessing.connection import wait

from companion.campaigns.environment import environment_of
from companion.campaigns.fairness import unfair
from companion.campaigns.kit import Kit
from companion.campaigns.measuring import fly
from companion.campaigns.outcomes import FlownRow, RowOutcome
from companion.campaigns.rows import Row
from companion.errors import MissionError


@dataclass(frozen=True, slots=True)
class WorkerRefused:
    """A worker would fly other bytes.

    Attributes:
        worker: its machine.
        line: of the header, that differs.
    """

    worker: str
    line: str


def begin() -> None:
    """What a process of a local pool does first.

    Ctrl-C is for the campaign alone, which lets it finish its row; while the process was not so
    far it was blocked. It ends with the campaign, also when that is killed.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})
    if (parent := multiprocessing.parent_process()) is not None:
        threading.Thread(target=_end_with, args=(parent.sentinel,), daemon=True).start()


def _end_with(sentinel: int) -> None:
    wait([sentinel])
    os._exit(1)


def fly_row(packed: bytes, row: Row) -> FlownRow | WorkerRefused:
    """Flies a row of a kit in this process."""
    kit = _kit(packed)
    if differs := _difference(packed):
        return WorkerRefused(platform.node(), differs)
    try:
        try:
            world = kit.scenario.world(row.values)
        except MissionError as error:
            return FlownRow(row, RowOutcome.INVALID, reason=error.what)
        moved = kit.scenario.moved_obstacles(row.values)
        if reason := unfair(kit.mission, world[0], moved):
            return FlownRow(row, RowOutcome.INVALID, reason=reason)
        return fly(kit.mission, world, row, kit.limit_s)
    except Exception as error:
        said = traceback.format_exception_only(error)[-1].strip()
        return FlownRow(row, RowOutcome.ERROR, reason=said.partition("\n")[0])
    finally:
        gc.collect()  # the parts of a flight hold each other: left alone, a hundred stay


@lru_cache(maxsize=2)
def _kit(packed: bytes) -> Kit:
    return Kit.unpacked(packed)


@lru_cache(maxsize=2)
def _difference(packed: bytes) -> str:
    """The first line of the kit's environment that is another one here."""
    kit = _kit(packed)
    here, wanted = environment_of(kit.mission), kit.environment.items()
    return next((f"{k}: {here.get(k)}, not {v}" for k, v in wanted if here.get(k) != v), "")
