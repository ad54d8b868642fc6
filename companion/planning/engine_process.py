"""What runs in an engine's process: it compiles the problem and calls the planner.

A planner may hang, crash, fill the memory, print, start processes, and leave files (Fast Downward
writes output.sas into the working directory). The compilation of a large task may not end either.
So each question gets a confined process and folder of its own. At the time limit, and when the
caller is interrupted, the process ends all that the planner has started. This module is a door.
"""

from __future__ import annotations

import contextlib
import os
import signal
import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from multiprocessing.connection import Connection
from types import FrameType
from typing import Any

from companion.errors import CompanionError, RequestError
from companion.planning.compilation.classical import ClassicalProblem
from companion.planning.compilation.decode import decode
from companion.planning.compilation.encode import encode
from companion.planning.compilation.monolithic import monolithic
from companion.planning.compilation.pddl import naming
from companion.planning.lasso import Letter, Problem
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
"""The command that installs an engine, by the beginning of the engine's name."""
NO_COSTS = ("pyperplan",)
"""Engines that ignore costs of actions and look for a plan with few actions."""
GRACE_S = 2.0
"""A process is killed from outside when it exceeds its limit by this time."""
MEMORY_BYTES = 1024 * MIB
"""Memory limit of the process and of each one that a planner starts. The limit of processor time is
that of the question."""


class EngineError(CompanionError):
    """A planner is missing, or gave no answer."""


class EngineMissing(EngineError):
    """No planner of that name is installed; the message says what to install, or what there is."""

    exit_code = 2


class EngineUnfit(EngineError):
    """The planner cannot do what is asked of it; the message says what to ask for instead."""

    exit_code = 2


class _TimeIsOver(Exception):
    """Raised by the alarm at the time limit."""


@dataclass(frozen=True, slots=True)
class EngineQuestion:
    """What a planner is asked.

    Attributes:
        problem: the problem, with the state to plan from.
        histories: per conjunct, the letters that it has read, including the present position's.
        encoding: how the task is compiled.
        objective: `LAP` or `SUM`.
    """

    problem: Problem
    histories: Sequence[Sequence[Letter]]
    encoding: Encoding
    objective: Objective

    def compiled(self) -> ClassicalProblem:
        """The classical problem.

        Raises:
            CompanionError: the encoding cannot express the task, or it would be too large.
        """
        is_paper_s = self.encoding is Encoding.V1
        asked = monolithic(self.problem, self.histories) if is_paper_s else self.problem
        return encode(asked, self.encoding, self.objective)


@dataclass(frozen=True, slots=True)
class EngineAnswer:
    """The answer to a question.

    Attributes:
        status: status in the words of unified-planning.
        prefix, loop: names of actions of the problem; without a loop there is no plan.
    """

    status: str
    prefix: tuple[str, ...] = ()
    loop: tuple[str, ...] = ()


def run(
    pipe: Connection, folder: str, question: EngineQuestion, engine: str, timeout_s: float
) -> None:
    """Does all the work of the process: sends an `EngineAnswer` or an `EngineError`.

    Args:
        pipe: connection to whoever asks.
        folder: folder in which the planner may write.
        question: the question.
        engine: the planner's name in unified-planning.
        timeout_s: the process ends itself after this time.
    """
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
            started = getattr(planner, "_process", None)  # it is in a session of its own
            if started is not None:
                with contextlib.suppress(ProcessLookupError):
                    os.killpg(started.pid, signal.SIGKILL)
        if number == signal.SIGTERM:
            os._exit(1)
        raise _TimeIsOver

    signal.signal(signal.SIGTERM, stop)
    signal.signal(signal.SIGALRM, stop)
    signal.setitimer(signal.ITIMER_REAL, timeout_s)
    answer: EngineError | EngineAnswer
    try:
        classical = question.compiled()
        planners.append(_planner(engine, _parameters(engine, classical)))
        answer = _answer(planners[0], classical, engine)
    except (EngineMissing, EngineUnfit) as error:
        answer = error
    except RequestError as error:
        answer = EngineUnfit(str(error))
    except CompanionError as error:
        answer = EngineError(str(error))
    except _TimeIsOver:
        answer = EngineAnswer("TIMEOUT")
    except MemoryError:
        answer = EngineAnswer("MEMOUT")
    except Exception as error:  # an engine may raise anything
        answer = EngineError(f"the engine {engine} failed: {type(error).__name__}: {error}")
    signal.setitimer(signal.ITIMER_REAL, 0)
    pipe.send(answer)


def look_up(pipe: Connection, folder: str, engine: str, encoding: Encoding) -> None:
    """Does all the work of a process that looks up whether an engine exists and takes an encoding.

    Sends an `EngineAnswer`, or an `EngineError`.
    """
    from unified_planning.model import ProblemKind

    answer: EngineError | EngineAnswer = EngineAnswer("THERE")
    try:
        has_effects = encoding is not Encoding.V5
        kind = ProblemKind({"ACTION_BASED"} | ({"CONDITIONAL_EFFECTS"} if has_effects else set()))
        if not _planner(engine, {}).supports(kind):
            answer = _unsupported(encoding, engine, sorted(kind.features))
    except EngineMissing as error:
        answer = error
    pipe.send(answer)


def _planner(engine: str, parameters: dict[str, Any]) -> Any:
    from unified_planning.exceptions import UPException
    from unified_planning.shortcuts import OneshotPlanner, get_environment

    get_environment().credits_stream = None
    factory = get_environment().factory
    known = [e for e in factory.engines if "[" not in e and factory.engine(e).is_oneshot_planner()]
    try:
        return OneshotPlanner(name=engine, params=parameters)
    except (UPException, ImportError, AssertionError) as error:
        line = next((text for name, text in INSTALL.items() if engine.startswith(name)), None)
        raise EngineMissing(
            f"the engine {engine} is not installed; {line}"
            if line
            else f"there is no engine {engine}; installed are: {', '.join(sorted(known))}"
        ) from error


def _parameters(engine: str, classical: ClassicalProblem) -> dict[str, Any]:
    """Parameters with which Fast Downward finds a cheapest plan, or proves there is none."""
    if engine != FAST_DOWNWARD:
        return {}
    heuristic = "hmax" if classical.has_conditional_effects else "lmcut"
    return {
        # To find invariants of a large automaton takes longer than they save in the search.
        "fast_downward_translate_options": ["--invariant-generation-max-time", "0"],
        "fast_downward_search_config": f"astar({heuristic}())",
    }


def _unsupported(encoding: Encoding, engine: str, features: list[str]) -> EngineUnfit:
    if encoding is not Encoding.V5:
        return EngineUnfit(
            f"the engine {engine} cannot take encoding {encoding}, which has conditional "
            "effects; use encoding v5"
        )
    return EngineUnfit(
        f"the engine {engine} cannot take plain problems with costs ({', '.join(features)}); "
        f"use {FAST_DOWNWARD}"
    )


def _answer(planner: Any, classical: ClassicalProblem, engine: str) -> EngineAnswer:
    task = _task(classical, has_costs=not engine.startswith(NO_COSTS))
    if not planner.supports(task.kind):
        raise _unsupported(classical.encoding, engine, sorted(task.kind.features))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # about features that an engine lacks and we do not use
        result = planner.solve(task)
    if result.plan is None:
        return EngineAnswer(result.status.name)
    name_of = {word: name for name, word in naming(classical).actions.items()}
    lasso = decode(classical, [name_of[step.action.name] for step in result.plan.actions])
    prefix, loop = (tuple(a.name for a in part) for part in (lasso.prefix, lasso.loop))
    return EngineAnswer(result.status.name, prefix, loop)


def _task(classical: ClassicalProblem, has_costs: bool) -> Any:
    """The problem as an object of unified-planning; its PDDL reader would take longer."""
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
