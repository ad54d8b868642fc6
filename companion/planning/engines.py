"""Classical planners through unified-planning: they solve a compiled task (`compilation/`).

Fast Downward is the default, pyperplan a second planner for encoding v5; any other engine that
unified-planning knows goes by its name. The planners are optional (extra `planners`), and they are
met when a plan is asked for, in a confined process for each question (`engine_process.py`): neither
what they do nor the size of a compiled task reaches the caller. What comes back is names; every
plan is checked here. Processes are forked from a server that has the library loaded, for that takes
a second. This module is a door.
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
"""What may be waited for the word whether an engine is there; a plan tells it later, too."""

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
    """A checked lasso by way of a classical planner; None if it is proved that there is none.

    Its bound is not known: a compiled task closes a loop where the automata are as they were, and
    a loop that does not lead them back at once may be better.

    Args:
        problem: from where to plan.
        histories: per conjunct, the letters that it has read, the present position's included.
        engine: its name in unified-planning.
        encoding: how the task is compiled.
        objective: `LAP` or `SUM`.
        timeout_s: after this many seconds, in which the task is compiled too, the engine is ended.
        stop: it is ended when the other end of this pipe is closed.

    Raises:
        EngineError: the engine is missing, cannot take the problem, failed, or took too long; the
            encoding cannot express the task; or the problem has energy or bounds in time, of
            which no engine knows.
        CompanionError: the engine made a wrong plan; or an argument is of another kind.
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
    """Refuses an engine that cannot plan, before anything is done for a flight with it.

    Args:
        engine: its name in unified-planning.
        encoding: how the task is compiled.
        mission: what is flown; None while it is not known.

    Raises:
        EngineMissing: it is not here.
        EngineUnfit: it cannot take the encoding, or what the mission has.
    """
    if mission is not None:
        _refuse(engine, mission.battery is not None, mission.is_timed)
    _asked(partial(engine_process.look_up, engine=engine, encoding=encoding), LOOK_UP_S)


def _refuse(engine: str, has_energy: bool, has_bounds: bool) -> None:
    """Raises an EngineUnfit for what no engine knows of."""
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
    """Returns if it is proved that there is none.

    Raises:
        EngineError: it is not.
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
    """The plan in the problem's own actions; None if it has others."""
    known = {action.name: action for action in problem.actions}
    if not known.keys() >= {*answer.prefix, *answer.loop}:
        return None
    prefix, loop = (tuple(known[name] for name in part) for part in (answer.prefix, answer.loop))
    return Lasso(prefix, loop)


def _asked(
    ask: Callable[[Connection, str], None], timeout_s: float, stop: Connection | None = None
) -> EngineAnswer:
    """What a process of its own answers.

    Args:
        ask: all that the process does, given a pipe to here and a folder.
        timeout_s: after this many seconds, and a little more, it is ended.
        stop: it is ended when the other end of this pipe is closed.

    Raises:
        EngineError: as it says.
    """
    here, there = _server.Pipe(duplex=False)
    with tempfile.TemporaryDirectory(prefix="companion-", ignore_cleanup_errors=True) as folder:
        process = _server.Process(target=ask, args=(there, folder), daemon=True)
        try:
            process.start()
        except (EOFError, OSError):  # the server has died just now; the next call starts it again
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
