"""An engine beside the loop: polled in real time, waited for after a set time in lockstep."""

from __future__ import annotations

import threading
from collections.abc import Callable
from multiprocessing.connection import Connection
from typing import Any

import pytest
from compiled import history, problem, unit_costs

from companion.errors import CompanionError
from companion.outcomes import Failed
from companion.planning.builtin.search import Search
from companion.planning.engine_jobs import EngineJobs
from companion.planning.engine_process import EngineError
from companion.planning.engines import EngineTimeout
from companion.planning.lasso import Lasso, Problem, Solution
from companion.planning.objective import Encoding

Solve = Callable[[Connection], Solution | None]
WAITED_S = 10.0
LATE = EngineTimeout("the engine slow did not answer in 3 s")


@pytest.fixture
def asked() -> Problem:
    return problem("HA", unit_costs("HA"), "G F at(A)")


@pytest.fixture
def answer(monkeypatch: pytest.MonkeyPatch) -> Callable[[Solve], None]:
    """Sets what the engine answers, given the pipe that ends it."""

    def set_to(solve: Solve) -> None:
        def solve_with(*_: object, stop: Any = None) -> Solution | None:
            return solve(stop)

        monkeypatch.setattr("companion.planning.engine_jobs.solve_with", solve_with)

    return set_to


def engine(duration_s: float | None = None) -> EngineJobs:
    return EngineJobs("slow", Encoding.V4, 3.0, duration_s)


def solution(asked: Problem) -> Solution:
    *_, best = Search().solutions(asked)
    return best


def raising(error: Exception) -> Solve:
    def solve(stop: Connection) -> Solution | None:
        raise error

    return solve


def answered(jobs: EngineJobs, asked: Problem, now_s: float = 5.0) -> Lasso | Failed | None:
    """The answer when the engine has come to an end."""
    job = jobs.begin(asked, history(asked), 5.0)
    join_workers()
    return job.answer(now_s)


def join_workers() -> None:
    for thread in threading.enumerate():
        if thread.name.endswith("(work)"):
            thread.join(WAITED_S)


def test_in_real_time_nothing_waits(asked: Problem, answer: Callable[[Solve], None]) -> None:
    go, best = threading.Event(), solution(asked)

    def solve(stop: Connection) -> Solution:
        go.wait(WAITED_S)
        return best

    answer(solve)
    job = engine().begin(asked, history(asked), 5.0)
    assert job.answer(5.0) is None and job.answer(1e6) is None
    go.set()
    join_workers()
    assert job.answer(5.05) is best.lasso


def test_in_lockstep_an_answer_comes_after_the_set_time(
    asked: Problem, answer: Callable[[Solve], None]
) -> None:
    best = solution(asked)
    answer(lambda stop: best)
    job = engine(duration_s=2.0).begin(asked, history(asked), 5.0)
    assert job.answer(5.0) is None and job.answer(6.95) is None
    assert job.answer(7.0) is best.lasso


def test_a_time_limit_is_a_failure_in_real_time_and_ends_a_flight_in_lockstep(
    asked: Problem, answer: Callable[[Solve], None]
) -> None:
    """In lockstep another machine, or the same one tomorrow, would fly another flight."""
    answer(raising(LATE))
    assert answered(engine(), asked) == Failed(str(LATE))
    with pytest.raises(EngineTimeout):
        answered(engine(duration_s=0.0), asked)
    assert engine().plan(asked, history(asked)) == Failed(str(LATE))
    with pytest.raises(EngineTimeout):
        engine(duration_s=0.0).plan(asked, history(asked))


@pytest.mark.parametrize("duration_s", [None, 0.0])
def test_an_engine_that_fails_or_finds_nothing_leaves_it_to_the_built_in_search(
    asked: Problem, answer: Callable[[Solve], None], duration_s: float | None
) -> None:
    answer(raising(CompanionError("the engine slow made a wrong plan")))
    failed = Failed("the engine slow made a wrong plan")
    assert answered(engine(duration_s), asked) == failed
    answer(lambda stop: None)
    assert answered(engine(duration_s), asked) == Failed("the engine slow finds no plan")


def test_an_engine_that_is_missing_is_told_before_the_flight(
    asked: Problem, answer: Callable[[Solve], None]
) -> None:
    answer(raising(EngineError("the engine slow is not installed")))
    with pytest.raises(EngineError, match="not installed"):
        engine().plan(asked, history(asked))


def test_an_engine_that_nobody_waits_for_is_ended(
    asked: Problem, answer: Callable[[Solve], None]
) -> None:
    ended = threading.Event()

    def solve(stop: Connection) -> None:
        if stop.poll(WAITED_S):  # the other end was closed
            ended.set()

    answer(solve)
    engine().begin(asked, history(asked), 5.0).abandon()
    assert ended.wait(WAITED_S)
