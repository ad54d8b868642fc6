"""The table of contingencies of a mission, computed on all cores.

Each process prepares the mission and answers some of the questions. The questions are independent,
and the answers keep their order, so the table does not depend on the number of processes.
"""

from __future__ import annotations

import multiprocessing
import os
import signal
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from types import NoneType

from companion.acting.contingencies.listing import Contingencies, ContingencyQuestion
from companion.acting.contingencies.table import Contingency, ContingencyTable
from companion.arguments import check_function, check_kind
from companion.errors import CompanionError
from companion.mission.model import Mission

FEW_ANSWERS = 100
"""This many contingencies are not worth another process, which takes a second to start."""

OnProgress = Callable[[int, int], None]
"""Called with the number of contingencies done, and the number of all."""

_asked: Contingencies | None = None
"""The mission's contingencies, in a process that answers for another one."""


def contingencies(
    mission: Mission, jobs: int | None = None, on_progress: OnProgress | None = None
) -> ContingencyTable:
    """What a flight does after each single change, at each position of its first plan.

    >>> from companion import load_mission
    >>> print(contingencies(load_mission("missions/surveillance.yaml"), jobs=1))
    60 contingencies: 48 planned, 12 end at Home, 0 unsafe

    Args:
        mission: the mission to examine.
        jobs: number of processes; None means one per core.
        on_progress: called after each contingency; an event counts as one, whatever its outcomes.

    Raises:
        NoPlanError: the mission has no first plan.
        CompanionError: it is no mission, or has its own tree; the number of jobs is below 1; or a
            process has died.
    """
    check_kind(mission, Mission, "a mission, as of load_mission")
    check_kind(jobs, (int, NoneType), "a number of jobs")
    if jobs is not None and jobs < 1:
        raise CompanionError(f"{jobs} is no number of jobs; give 1 or more")
    if on_progress is not None:
        check_function(on_progress, "on_progress")
    asked = Contingencies(mission)
    questions = asked.questions
    total = sum(len(question.positions) for question in questions)
    many = jobs if jobs is not None else usable_cores()
    is_alone = many <= 1 or total <= FEW_ANSWERS
    answers = map(asked.answer, questions) if is_alone else _in_processes(mission, questions, many)
    return asked.table(_counted(answers, questions, total, on_progress))


def usable_cores() -> int:
    """The number of cores that this process may use, as far as the system says so."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def _counted(
    answers: Iterable[tuple[Contingency, ...]],
    questions: Iterable[ContingencyQuestion],
    total: int,
    on_progress: OnProgress | None,
) -> Iterator[tuple[Contingency, ...]]:
    done = 0
    for answer, question in zip(answers, questions, strict=True):
        done += len(question.positions)
        if on_progress is not None:
            on_progress(done, total)
        yield answer


def _in_processes(
    mission: Mission, questions: tuple[ContingencyQuestion, ...], jobs: int
) -> Iterator[tuple[Contingency, ...]]:
    """The answers, in order; when this generator ends, the processes end too."""
    before = set(multiprocessing.active_children())
    server = multiprocessing.get_context("forkserver")
    pool = ProcessPoolExecutor(
        min(jobs, len(questions)), mp_context=server, initializer=_begin, initargs=(mission,)
    )
    try:
        yield from pool.map(_answer, questions)
    except BrokenProcessPool as error:
        raise CompanionError(
            "a process that looks at contingencies has ended early\n"
            "    has the machine enough memory? try --jobs 1"
        ) from error
    finally:
        children = set(multiprocessing.active_children()) - before
        pool.shutdown(wait=False, cancel_futures=True)
        for child in children:
            child.terminate()


def _begin(mission: Mission) -> None:
    global _asked
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the parent process
    _asked = Contingencies(mission)


def _answer(question: ContingencyQuestion) -> tuple[Contingency, ...]:
    assert _asked is not None
    return _asked.answer(question)
