"""What a worker process does: it unpacks a kit once, then flies rows.

No row ends the campaign: an exception becomes the outcome `error`. A worker whose environment
differs from the kit's flies nothing and reports the difference.
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
    """A worker has another environment, so its flights would differ.

    Attributes:
        worker: its machine.
        line: the header line that differs.
    """

    worker: str
    line: str


def begin() -> None:
    """The first call in a process of a local pool.

    Ctrl-C is for the campaign alone, which lets the process complete its row; the signal was
    blocked until here. The process ends with the campaign, even if that is killed.
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
        gc.collect()  # its parts form cycles: a hundred flights would stay


@lru_cache(maxsize=2)
def _kit(packed: bytes) -> Kit:
    return Kit.unpacked(packed)


@lru_cache(maxsize=2)
def _difference(packed: bytes) -> str:
    """The first line of the kit's environment that differs here."""
    kit = _kit(packed)
    here, wanted = environment_of(kit.mission), kit.environment.items()
    return next((f"{k}: {here.get(k)}, not {v}" for k, v in wanted if here.get(k) != v), "")
