"""Flies rows in running processes of this machine.

1. Each process is a pool of its own with one row under way, so if it dies, its row is known.
2. A dead process is replaced, and its row is flown again. A row that has killed its process three
   times gets the outcome `died`. The other processes continue.
3. Rows are handed out one by one, because they take from a tenth of a second to a minute.
4. Processes are spawned: JSBSim and the libraries of numpy do not survive a fork.
"""

from __future__ import annotations

import os
import signal
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import suppress
from multiprocessing import get_context
from typing import Protocol

from companion.campaigns.outcomes import FlownRow, RowOutcome
from companion.campaigns.rows import Row
from companion.campaigns.worker import WorkerRefused, begin, fly_row
from companion.errors import CompanionError

FlyRow = Callable[[bytes, Row], FlownRow | WorkerRefused]
"""Flies a row of a kit in the process in which it is called."""
TRIES = 3
ONE_THREAD = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
"""Flights hold the interpreter lock, so more threads of a library only disturb each other."""


class RowEngine(Protocol):
    """Flies rows somewhere."""

    def fly(self, rows: Iterable[Row]) -> Iterator[FlownRow]:
        """The rows, in the order in which they finish.

        Raises:
            CompanionError: a worker has another environment, so its flights would differ.
        """

    def finish(self) -> Iterator[FlownRow]:
        """The rows under way, in the order in which they finish; submits no more."""

    def close(self) -> None:
        """Ends the rows under way."""


class LocalProcesses:
    """Flies rows in processes of this machine.

    Args:
        packed: the kit.
        jobs: the number of processes.
        fly: what a process does with a row.
    """

    def __init__(self, packed: bytes, jobs: int, fly: FlyRow = fly_row) -> None:
        for name in ONE_THREAD:
            os.environ.setdefault(name, "1")
        self._packed, self._fly = packed, fly
        self._workers = [_Worker() for _ in range(jobs)]
        self._under_way: dict[Future[FlownRow | WorkerRefused], tuple[_Worker, Row]] = {}
        self._again: list[Row] = []
        self._deaths = Deaths()

    @property
    def pids(self) -> list[int]:
        """The ids of the running processes."""
        return [pid for worker in self._workers if (pid := worker.pid) is not None]

    def fly(self, rows: Iterable[Row]) -> Iterator[FlownRow]:
        """The rows, in the order in which they finish."""
        waiting = iter(rows)
        while True:
            self._submit(waiting)
            if not self._under_way:
                return
            yield from self._returned()

    def finish(self) -> Iterator[FlownRow]:
        """The rows under way, in the order in which they finish."""
        while self._under_way:
            yield from self._returned()

    def close(self) -> None:
        """Ends all processes."""
        for worker in self._workers:
            worker.kill()

    def _submit(self, waiting: Iterator[Row]) -> None:
        busy = {worker for worker, _ in self._under_way.values()}
        for worker in [worker for worker in self._workers if worker not in busy]:
            row = self._again.pop() if self._again else next(waiting, None)
            if row is None:
                return
            try:
                future = worker.submit(self._fly, self._packed, row)
            except BrokenProcessPool:  # it has died without a row
                worker = self._replaced(worker)
                future = worker.submit(self._fly, self._packed, row)
            self._under_way[future] = worker, row

    def _returned(self) -> Iterator[FlownRow]:
        done, _ = wait(self._under_way, return_when=FIRST_COMPLETED)
        for future in done:
            worker, row = self._under_way.pop(future)
            try:
                yield accepted(future.result())
            except BrokenProcessPool:
                self._replaced(worker)
                if self._deaths.is_last(row):
                    yield died(row)
                else:
                    self._again.append(row)

    def _replaced(self, worker: _Worker) -> _Worker:
        another = _Worker()
        self._workers[self._workers.index(worker)] = another
        return another


class _Worker:
    """A pool of one process."""

    def __init__(self) -> None:
        self._pool = ProcessPoolExecutor(1, get_context("spawn"), begin)
        before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})  # until `begin`
        try:
            self._pid = self._pool.submit(os.getpid)  # the process inherits the mask
        finally:
            signal.pthread_sigmask(signal.SIG_SETMASK, before)

    @property
    def pid(self) -> int | None:
        """The id of its process, once it has started."""
        is_there = self._pid.done() and self._pid.exception() is None
        return self._pid.result() if is_there else None

    def submit(self, fly: FlyRow, packed: bytes, row: Row) -> Future[FlownRow | WorkerRefused]:
        return self._pool.submit(fly, packed, row)

    def kill(self) -> None:
        self._pool.shutdown(wait=False, cancel_futures=True)
        if self.pid is not None:
            with suppress(ProcessLookupError):
                os.kill(self.pid, signal.SIGTERM)


class Deaths:
    """Counts how often each row has killed the process that flew it."""

    def __init__(self) -> None:
        self._of_row: Counter[int] = Counter()

    def is_last(self, row: Row) -> bool:
        """Counts a death; returns whether this was the row's last try."""
        self._of_row[row.index] += 1
        return self._of_row[row.index] >= TRIES


def accepted(answer: FlownRow | WorkerRefused) -> FlownRow:
    """The row from a worker's answer.

    Raises:
        CompanionError: the worker has another environment, so its flights would differ.
    """
    if isinstance(answer, WorkerRefused):
        raise CompanionError(
            f"the worker on {answer.worker} would fly other rows than this machine\n"
            f"    {answer.line}\n"
            "    install the same release and libraries on machines of one kind"
        )
    return answer


def died(row: Row) -> FlownRow:
    """The result of a row that has killed each process that flew it."""
    return FlownRow(row, RowOutcome.DIED, reason=f"its process died {TRIES} times")
