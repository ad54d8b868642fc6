"""Engines of unified-planning in flight: they compile and solve problems beside the flight loop.

A thread waits for the engine's process (`engines.py`) and checks its plan. The flight loop asks in
each tick whether there is an answer. In lockstep, simulated time waits for the engine, and the
answer comes after a configured simulated duration. So equal flights have equal events, however fast
the machine is. This module starts threads and processes: it is a door.
"""

from __future__ import annotations

import multiprocessing
import threading
from collections.abc import Sequence
from concurrent.futures import Future
from dataclasses import dataclass

from companion.errors import CompanionError
from companion.outcomes import Failed
from companion.planning.engines import EngineTimeout, solve_with
from companion.planning.lasso import Lasso, Letter, Problem
from companion.planning.objective import Encoding, Objective


@dataclass(frozen=True, slots=True)
class EngineJobs:
    """An engine that plans for a flight; it implements `Engine`.

    Attributes:
        engine: name of the engine in unified-planning.
        encoding: how problems are compiled for it.
        timeout_s: limit of real time.
        duration_s: simulated time until its answer, in lockstep; None in real time. In lockstep,
            exceeding the time limit ends the flight, because the flight would differ on another
            machine.
    """

    engine: str
    encoding: Encoding
    timeout_s: float
    duration_s: float | None = None

    def plan(self, problem: Problem, histories: Sequence[Sequence[Letter]]) -> Lasso | Failed:
        """The plan before a flight."""
        try:
            solution = solve_with(
                problem, histories, self.engine, self.encoding, Objective.LAP, self.timeout_s
            )
        except EngineTimeout as late:
            if self.duration_s is not None:
                raise
            return Failed(str(late))
        return solution.lasso if solution else self.finds_nothing

    @property
    def finds_nothing(self) -> Failed:
        """What is reported if the engine says that there is no plan."""
        return Failed(f"the engine {self.engine} finds no plan")

    def begin(self, problem: Problem, histories: Sequence[Sequence[Letter]], now_s: float) -> _Job:
        """Begins to plan."""
        return _Job(self, problem, [tuple(history) for history in histories], now_s)


class _Job:
    """A problem that an engine works on; it implements `EngineJob`."""

    def __init__(
        self,
        jobs: EngineJobs,
        problem: Problem,
        histories: Sequence[Sequence[Letter]],
        begin_s: float,
    ) -> None:
        self._jobs = jobs
        self._due_s = begin_s + (jobs.duration_s or 0.0)
        self._found: Future[Lasso | None] = Future()
        stop, self._stopping = multiprocessing.Pipe(duplex=False)

        def work() -> None:
            try:
                solution = solve_with(
                    problem,
                    histories,
                    jobs.engine,
                    jobs.encoding,
                    Objective.LAP,
                    jobs.timeout_s,
                    stop=stop,
                )
                self._found.set_result(solution.lasso if solution else None)
            except BaseException as error:  # raised again when the answer is asked for
                self._found.set_exception(error)

        threading.Thread(target=work, daemon=True).start()

    def answer(self, now_s: float) -> Lasso | Failed | None:
        """The plan, or why there is none; None while the engine works."""
        if self._jobs.duration_s is None:
            return self._result() if self._found.done() else None
        return self._result() if now_s >= self._due_s else None

    def _result(self) -> Lasso | Failed:
        """The plan, or why there is none, after the engine has answered."""
        try:
            lasso = self._found.result()
        except EngineTimeout as late:
            if self._jobs.duration_s is not None:
                raise
            return Failed(str(late))
        except CompanionError as failure:
            return Failed(str(failure))
        return lasso or self._jobs.finds_nothing

    def abandon(self) -> None:
        """Ends the engine if it still works."""
        self._stopping.close()
