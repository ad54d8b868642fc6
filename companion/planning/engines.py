"""Classical planners through unified-planning: they solve a compiled task (`compilation/`).

Fast Downward is the default, pyperplan a second planner for encoding v5; any other engine that
unified-planning knows goes by its name. The planners are optional (extra `planners`), and they are
met here alone, when a plan is asked for. Planners are processes: this module is a door.

A planner may hang, crash, fill the memory, print, leave files (Fast Downward its output.sas, where
it is called) and start processes. So each call has a confined child process of its own in a folder
of its own. At the time limit, and when the caller is interrupted, the child ends what the planner
has started. Children are forked from a server that has the library loaded, for that takes a second.
"""

from __future__ import annotations

import contextlib
import multiprocessing
import os
import signal
import tempfile
import warnings
from collections.abc import Sequence
from dataclasses import dataclass, field
from multiprocessing.connection import Connection, wait
from types import FrameType
from typing import Any

from companion.errors import CompanionError
from companion.planning.check import fault
from companion.planning.compilation.classical import ClassicalProblem
from companion.planning.compilation.decode import decode
from companion.planning.compilation.encode import encode
from companion.planning.compilation.monolithic import monolithic
from companion.planning.compilation.pddl import naming
from companion.planning.lasso import Letter, Problem, Solution
from companion.planning.objective import Encoding, Objective
from companion.python_child import MIB, confine_memory, confine_time

FAST_DOWNWARD = "fast-downward"
INSTALL = {
    "fast-downward": "pip install 'mav-companion[planners]'",
    "pyperplan": "pip install 'mav-companion[planners]'",
    "symk": "pip install up-symk",
    "enhsp": "pip install up-enhsp   (needs Java 17)",
    "lpg": "pip install up-lpg",
    "tamer": "pip install up-tamer",
}
"""The command that installs an engine, by the beginning of its name."""
NO_COSTS = ("pyperplan",)
"""Engines that take no costs of actions and look for a plan of few actions."""
FAILURES = {
    "MEMOUT": "ran out of memory; use another encoding, or the built-in search",
    "UNSOLVABLE_INCOMPLETELY": f"found no plan and cannot say if there is one; {FAST_DOWNWARD} can",
}
"""Texts for statuses without an answer: what the engine did, and what to do."""
GRACE_S = 2.0
"""Time beyond its limit after which a child is killed from outside."""
MEMORY_BYTES = 1024 * MIB
"""Of a child, and of each process that a planner starts; no more processor time than its limit."""

_server = multiprocessing.get_context("forkserver")
_server.set_forkserver_preload(
    ["unified_planning.shortcuts", "up_fast_downward", "up_pyperplan.engine"]
)


class EngineError(CompanionError):
    """A planner is missing, or gave no answer."""


class EngineTimeout(EngineError):
    """A planner gave no answer within its time limit."""


class _TimeIsOver(Exception):
    """Raised in the child by its alarm."""


@dataclass(frozen=True)
class _Setup:
    """The call of an engine.

    Attributes:
        proves_absence: no plan found means that there is none, even if the engine does not say so.
    """

    parameters: dict[str, Any] = field(default_factory=dict)
    proves_absence: bool = False


def _setup(classical: ClassicalProblem, engine: str, optimal: bool) -> _Setup:
    if engine != FAST_DOWNWARD:
        return _Setup()
    # Finding invariants of a large automaton takes longer than the search that they help.
    options = ["--invariant-generation-max-time", "0"]
    parameters: dict[str, Any] = {"fast_downward_translate_options": options}
    if not optimal:
        return _Setup(parameters | {"fast_downward_alias": "lama-first"})
    heuristic = "hmax" if classical.has_conditional_effects else "lmcut"
    search = {"fast_downward_search_config": f"astar({heuristic}())"}
    return _Setup(parameters | search, proves_absence=True)


def solve(
    classical: ClassicalProblem,
    engine: str,
    timeout_s: float,
    optimal: bool,
    stop: Connection | None = None,
) -> list[str] | None:
    """A plan as the names of its actions; None if it is proved that there is none.

    Args:
        classical: the problem.
        engine: its name in unified-planning.
        timeout_s: after this many seconds the engine is ended.
        optimal: ask Fast Downward for a plan of least cost, else for any plan soon. Other engines
            have a name for each.
        stop: the engine is ended when the other end of this pipe is closed.

    Raises:
        EngineError: the engine is missing, cannot take the problem, failed, or took too long.
    """
    setup = _setup(classical, engine, optimal)
    status, names = _run(classical, engine, setup, timeout_s, stop)
    if status == "UNSOLVABLE_INCOMPLETELY" and engine == FAST_DOWNWARD and not optimal:
        setup = _setup(classical, engine, optimal=True)  # gave up; this one is complete
        status, names = _run(classical, engine, setup, timeout_s, stop)
    if names is not None:
        return names
    is_proved = status == "UNSOLVABLE_INCOMPLETELY" and setup.proves_absence
    if is_proved or status == "UNSOLVABLE_PROVEN":
        return None
    if status == "TIMEOUT":
        raise EngineTimeout(
            f"the engine {engine} did not answer in {timeout_s:g} s; raise the limit, or use the "
            "built-in search"
        )
    what = FAILURES.get(status, f"failed ({status}); use another engine, or the built-in search")
    raise EngineError(f"the engine {engine} {what}")


def solve_with(
    problem: Problem,
    histories: Sequence[Sequence[Letter]],
    engine: str,
    encoding: Encoding,
    objective: Objective,
    timeout_s: float,
    stop: Connection | None = None,
) -> Solution | None:
    """A checked lasso by way of a classical planner; None if the task cannot be done from here.

    Its bound is not known: a compiled task closes a loop where the automata are as they were, and
    a loop that does not lead them back at once may be better.

    Args:
        problem: from where to plan.
        histories: per conjunct, the letters that it has read, the present position's included.
        engine: its name in unified-planning.
        encoding: how the task is compiled.
        objective: `LAP` or `SUM`.
        timeout_s: after this many seconds the engine is ended.
        stop: it is ended when the other end of this pipe is closed.

    Raises:
        EngineError: as `solve` does.
        CompanionError: the encoding cannot express the task, or the engine made a wrong plan.
    """
    asked = monolithic(problem, histories) if encoding is Encoding.V1 else problem
    classical = encode(asked, encoding, objective)
    names = solve(classical, engine, timeout_s, optimal=True, stop=stop)
    if names is None:
        return None
    lasso = decode(classical, names)
    wrong = fault(problem, lasso, histories)
    if wrong is not None:
        raise CompanionError(f"the engine {engine} made a wrong plan, {lasso}: {wrong}")
    cost_ms = lasso.lap_cost_ms
    if objective is Objective.SUM:
        cost_ms += lasso.prefix_cost_ms
    return Solution(lasso, objective, cost_ms, 0, f"{engine} {encoding.value}")


def _run(
    classical: ClassicalProblem,
    engine: str,
    setup: _Setup,
    timeout_s: float,
    stop: Connection | None,
) -> tuple[str, list[str] | None]:
    """The engine's status, and its plan."""
    here, there = _server.Pipe(duplex=False)
    with tempfile.TemporaryDirectory(prefix="companion-", ignore_cleanup_errors=True) as folder:
        child = _server.Process(
            target=_child, args=(there, folder, classical, engine, setup, timeout_s), daemon=True
        )
        try:
            child.start()
        except (EOFError, OSError):  # the server has died just now; the next call starts it again
            here.close()
            return "INTERNAL_ERROR", None
        finally:
            there.close()
        try:
            heard = wait([here, stop] if stop else [here], timeout_s + GRACE_S)
            if here not in heard:
                return "TIMEOUT", None
            answer: EngineError | tuple[str, list[str] | None] = here.recv()
        except EOFError:
            return "INTERNAL_ERROR", None
        finally:
            here.close()
            child.terminate()  # it ends what the planner has started
            child.join(GRACE_S)
            child.kill()
            child.join()
    if isinstance(answer, EngineError):
        raise answer
    return answer


def _planner(engine: str, setup: _Setup) -> Any:
    from unified_planning.exceptions import UPException
    from unified_planning.shortcuts import OneshotPlanner, get_environment

    get_environment().credits_stream = None
    factory = get_environment().factory
    known = [e for e in factory.engines if "[" not in e and factory.engine(e).is_oneshot_planner()]
    try:
        return OneshotPlanner(name=engine, params=setup.parameters)
    except (UPException, ImportError, AssertionError) as error:
        line = next((text for name, text in INSTALL.items() if engine.startswith(name)), None)
        raise EngineError(
            f"the engine {engine} is not installed; {line}"
            if line
            else f"there is no engine {engine}; installed are: {', '.join(sorted(known))}"
        ) from error


def _unsupported(classical: ClassicalProblem, engine: str, features: list[str]) -> EngineError:
    if classical.encoding is not Encoding.V5:
        return EngineError(
            f"the engine {engine} cannot take encoding {classical.encoding}, which has conditional "
            "effects; use encoding v5"
        )
    return EngineError(
        f"the engine {engine} cannot take plain problems with costs ({', '.join(features)}); "
        f"use {FAST_DOWNWARD}"
    )


def _child(
    pipe: Connection,
    folder: str,
    classical: ClassicalProblem,
    engine: str,
    setup: _Setup,
    timeout_s: float,
) -> None:
    """Runs in a process of its own: sends the engine's answer, or an `EngineError`."""
    os.setsid()  # Ctrl-C in the terminal is the parent's business
    confine_memory(MEMORY_BYTES)
    confine_time(timeout_s + GRACE_S)
    os.chdir(folder)
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 1)
    os.dup2(nowhere, 2)
    planners: list[Any] = []

    def stop(number: int, frame: FrameType | None) -> None:
        for planner in planners:
            started = getattr(planner, "_process", None)  # in a session of its own
            if started is not None:
                with contextlib.suppress(ProcessLookupError):
                    os.killpg(started.pid, signal.SIGKILL)
        if number == signal.SIGTERM:
            os._exit(1)
        raise _TimeIsOver

    signal.signal(signal.SIGTERM, stop)
    signal.signal(signal.SIGALRM, stop)
    signal.setitimer(signal.ITIMER_REAL, timeout_s)
    answer: EngineError | tuple[str, list[str] | None]
    try:
        planners.append(_planner(engine, setup))
        answer = _answer(planners[0], classical, engine)
    except EngineError as error:
        answer = error
    except _TimeIsOver:
        answer = ("TIMEOUT", None)
    except MemoryError:
        answer = ("MEMOUT", None)
    except Exception as error:  # an engine may raise anything
        answer = EngineError(f"the engine {engine} failed: {type(error).__name__}: {error}")
    signal.setitimer(signal.ITIMER_REAL, 0)
    pipe.send(answer)


def _answer(planner: Any, classical: ClassicalProblem, engine: str) -> tuple[str, list[str] | None]:
    task = _task(classical, has_costs=not engine.startswith(NO_COSTS))
    if not planner.supports(task.kind):
        raise _unsupported(classical, engine, sorted(task.kind.features))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of features that an engine has not, and we do not ask
        result = planner.solve(task)
    if result.plan is None:
        return result.status.name, None
    name_of = {word: name for name, word in naming(classical).actions.items()}
    return result.status.name, [name_of[step.action.name] for step in result.plan.actions]


def _task(classical: ClassicalProblem, has_costs: bool) -> Any:
    """The problem in unified-planning's terms; its reader of PDDL would take longer."""
    from unified_planning.model import Fluent, InstantaneousAction, Problem
    from unified_planning.model.metrics import MinimizeActionCosts
    from unified_planning.shortcuts import And, BoolType, Int, Not

    names = naming(classical)
    task = Problem("task")
    fluent_of = {}
    for name, word in names.fluents.items():
        fluent_of[name] = Fluent(word, BoolType())
        task.add_fluent(fluent_of[name], default_initial_value=name in classical.init)
    costs = {}
    for action in classical.actions:
        made = InstantaneousAction(names.actions[action.name])
        for fluent in sorted(action.requires):
            made.add_precondition(fluent_of[fluent])
        for fluent in sorted(action.forbids):
            made.add_precondition(Not(fluent_of[fluent]))
        for fluent in sorted(action.deletes - action.adds):
            made.add_effect(fluent_of[fluent], False)
        for fluent in sorted(action.adds):
            made.add_effect(fluent_of[fluent], True)
        for effect in action.conditional:
            positive = [fluent_of[fluent] for fluent in sorted(effect.requires)]
            negative = [Not(fluent_of[fluent]) for fluent in sorted(effect.forbids)]
            condition = And(*positive, *negative)
            for fluent in sorted(effect.deletes - effect.adds):
                made.add_effect(fluent_of[fluent], False, condition)
            for fluent in sorted(effect.adds):
                made.add_effect(fluent_of[fluent], True, condition)
        task.add_action(made)
        costs[made] = Int(action.cost)
    for fluent in sorted(classical.goal):
        task.add_goal(fluent_of[fluent])
    if has_costs:
        task.add_quality_metric(MinimizeActionCosts(costs))
    return task
