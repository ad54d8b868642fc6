"""Classical planners through unified-planning: they solve a compiled task (`compilation/`).

Fast Downward is the default, and pyperplan the second planner, for encoding v5. Any other engine of
unified-planning is chosen by its name. The planners are optional (extra `planners`) and are first
looked for when a plan is asked for.

1. Each question has a confined process of its own (`engine_process.py`). So neither the planner nor
   the size of a compiled task can harm the caller.
2. The process returns names of actions; every plan is checked here.
3. Processes are forked from a server that has loaded the library, because that takes a second.

This module is a door.
"""

from __future__ import annotations

import multiprocessing
import tempfile
from collections.abc import Callable, Sequence
from functools import partial
from multiprocessing.connection import Connection, wait

from companion.arguments import check_kind, check_wait
from companion.errors import CompanionError
from companion.mission.model import Mission
from companion.planning import engine_process
from companion.planning.check import fault
from companion.planning.engine_process import (
    FAST_DOWNWARD,
    GRACE_S,
    EngineAnswer,
    EngineError,
    EngineQuestion,
    EngineUnfit,
)
from companion.planning.lasso import Lasso, Letter, Problem, Solution
from companion.planning.objective import Encoding, Objective

FAILURES = {
    "MEMOUT": "ran out of memory; use another encoding, or the built-in search",
    "UNSOLVABLE_INCOMPLETELY": f"found no plan and cannot say if there is one; {FAST_DOWNWARD} can",
}
"""Texts for statuses without an answer: what the engine did, and what to do."""
LOOK_UP_S = 10.0
"""Time limit for the question whether an engine exists; a later call to plan would tell, too."""

_server = multiprocessing.get_context("forkserver")
_server.set_forkserver_preload(
    [
        "companion.planning.engine_process",
        "unified_planning.shortcuts",
        "up_fast_downward",
        "up_pyperplan.engine",
    ]
)


class EngineTimeout(EngineError):
    """A planner gave no answer within its time limit."""


def solve_with(
    problem: Problem,
    histories: Sequence[Sequence[Letter]],
    engine: str,
    encoding: Encoding,
    objective: Objective,
    timeout_s: float,
    stop: Connection | None = None,
) -> Solution | None:
    """A checked lasso from a classical planner; None if it is proved that there is none.

    The bound of the solution is not known. A compiled task closes a loop only where the automata
    are in the same states again. A loop that brings them back only after several laps may be
    better.

    Args:
        problem: the problem, with the state to plan from.
        histories: per conjunct, the letters that it has read, including the present position's.
        engine: its name in unified-planning.
        encoding: how the task is compiled.
        objective: `LAP` or `SUM`.
        timeout_s: time limit of the engine, including the compilation of the task.
        stop: the engine is ended when the other end of this pipe is closed.

    Raises:
        EngineError: the engine is missing, cannot take the problem, failed, or took too long; the
            encoding cannot express the task; or the problem has energy or time bounds, which no
            engine supports.
        CompanionError: the engine made a wrong plan, or an argument has the wrong type.
    """
    check_kind(engine, str, "the name of an engine")
    check_wait(timeout_s)
    _refuse(engine, problem.energy is not None, bool(problem.clocks_ms))
    question = EngineQuestion(problem, histories, encoding, objective)
    ask = partial(engine_process.run, question=question, engine=engine, timeout_s=timeout_s)
    answer = _asked(ask, timeout_s, stop)
    if not answer.loop:
        _no_plan(answer.status, engine, timeout_s)
        return None
    lasso = _lasso(answer, problem)
    wrong = "an action that the task has not" if lasso is None else fault(problem, lasso, histories)
    if lasso is None or wrong is not None:
        plan = lasso or f"{', '.join((*answer.prefix, *answer.loop))}"
        raise CompanionError(f"the engine {engine} made a wrong plan, {plan}: {wrong}")
    cost_ms = lasso.lap_cost_ms
    if objective is Objective.SUM:
        cost_ms += lasso.prefix_cost_ms
    return Solution(lasso, objective, cost_ms, 0, f"{engine} {encoding.value}")


def require(engine: str, encoding: Encoding, mission: Mission | None) -> None:
    """Refuses an engine that cannot plan, before anything else is done for a flight.

    Args:
        engine: its name in unified-planning.
        encoding: how the task is compiled.
        mission: the mission to fly; None while it is not known.

    Raises:
        EngineMissing: the engine is not installed.
        EngineUnfit: the engine does not support the encoding, or what the mission has.
    """
    if mission is not None:
        _refuse(engine, mission.battery is not None, mission.is_timed)
    _asked(partial(engine_process.look_up, engine=engine, encoding=encoding), LOOK_UP_S)


def _refuse(engine: str, has_energy: bool, has_bounds: bool) -> None:
    """Raises EngineUnfit for energy and time bounds, which no engine supports."""
    if has_energy:
        raise EngineUnfit(
            f"the engine {engine} knows of no energy, and the mission has a battery; leave the "
            "engine out, so that the built-in search plans, or remove battery:"
        )
    if has_bounds:
        raise EngineUnfit(
            f"the engine {engine} knows of no bounds in time, and the task has some; leave the "
            "engine out, so that the built-in search plans, or remove the bounds"
        )


def _no_plan(status: str, engine: str, timeout_s: float) -> None:
    """Returns if it is proved that there is no plan.

    Raises:
        EngineError: it is not proved.
    """
    is_proved = status == "UNSOLVABLE_INCOMPLETELY" and engine == FAST_DOWNWARD  # by A*
    if is_proved or status == "UNSOLVABLE_PROVEN":
        return
    if status == "TIMEOUT":
        raise EngineTimeout(
            f"the engine {engine} did not answer in {timeout_s:g} s; raise the limit, or use the "
            "built-in search"
        )
    what = FAILURES.get(status, f"failed ({status}); use another engine, or the built-in search")
    raise EngineError(f"the engine {engine} {what}")


def _lasso(answer: EngineAnswer, problem: Problem) -> Lasso | None:
    """The plan with the problem's own actions; None if the engine names others."""
    known = {action.name: action for action in problem.actions}
    if not known.keys() >= {*answer.prefix, *answer.loop}:
        return None
    prefix, loop = (tuple(known[name] for name in part) for part in (answer.prefix, answer.loop))
    return Lasso(prefix, loop)


def _asked(
    ask: Callable[[Connection, str], None], timeout_s: float, stop: Connection | None = None
) -> EngineAnswer:
    """The answer of a process of its own.

    Args:
        ask: the work of the process, given a pipe to here and a folder.
        timeout_s: the process is ended shortly after this time.
        stop: the process is ended when the other end of this pipe is closed.

    Raises:
        EngineError: the process sent it.
    """
    here, there = _server.Pipe(duplex=False)
    with tempfile.TemporaryDirectory(prefix="companion-", ignore_cleanup_errors=True) as folder:
        process = _server.Process(target=ask, args=(there, folder), daemon=True)
        try:
            process.start()
        except (EOFError, OSError):  # the server has just died; the next call starts it again
            here.close()
            return EngineAnswer("INTERNAL_ERROR")
        finally:
            there.close()
        try:
            heard = wait([here, stop] if stop else [here], timeout_s + GRACE_S)
            if here not in heard:
                return EngineAnswer("TIMEOUT")
            answer: EngineError | EngineAnswer = here.recv()
        except EOFError:
            return EngineAnswer("INTERNAL_ERROR")
        finally:
            here.close()
            process.terminate()  # it ends what the planner has started
            process.join(GRACE_S)
            process.kill()
            process.join()
    if isinstance(answer, EngineError):
        raise answer
    return answer
