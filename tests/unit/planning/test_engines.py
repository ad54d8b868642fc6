"""Planners that others wrote, on compiled tasks: the paper's three plans, small tasks, failures."""

from __future__ import annotations

import itertools
import multiprocessing
import os
import signal
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from importlib.util import find_spec
from multiprocessing import forkserver
from pathlib import Path
from typing import NamedTuple

import bad_engines
import pytest
from compiled import action, history, problem, unit_costs
from reference_search import best_sum
from rig import Rig
from synthetic import facts_of

from companion.errors import CompanionError
from companion.flight_events.skills import PlaceReached
from companion.mission.model import Mission
from companion.mission.signals import Signal
from companion.motion.layered_routes import LayeredRoutes
from companion.outcomes import Failed, Progress
from companion.planning import engine_process, engines
from companion.planning.builtin.search import Search
from companion.planning.check import fault
from companion.planning.domain import ConditionalEffect
from companion.planning.engine_process import EngineAnswer, EngineError
from companion.planning.engines import solve_with
from companion.planning.lasso import Lasso, Letter, Problem, Solution
from companion.planning.objective import Encoding, Objective

pytestmark = pytest.mark.skipif(
    find_spec("up_fast_downward") is None, reason="the extra `planners` is not installed"
)

V1, V4, V5 = Encoding
TARGET = (Signal("NAMED_VALUE_INT", "target", "value"), 1.0)
LIMIT_S = 600.0
TASKS = [
    "G (F at(A) & F at(B))",
    "F (at(A) & F at(B))",
    "at(H) U at(B)",
    "G (at(A) -> X at(B)) & G F at(A)",
    "F G at(A)",
    "F G (at(A) | at(B)) & G F at(A) & G F at(B)",
    "X (at(A) & X (at(B) & X G at(B)))",
    "(!at(B)) U at(A) & F at(B)",
    "(F G at(A)) | (F G at(B))",
    "G F at(A) -> G F at(B)",
]


class Asked(NamedTuple):
    """A problem as the planner was asked it, with its histories."""

    problem: Problem
    histories: list[list[Letter]]


@pytest.fixture(scope="module")
def phases(surveillance: Mission, surveillance_routes: LayeredRoutes) -> list[Asked]:
    """Section V: the start; a target on the way to B; r1 refuses the upload."""
    rig = Rig(surveillance, surveillance_routes)
    replan = rig.planner.solver.replan
    asked: list[Asked] = []

    def noting_replan(problem: Problem, histories: Sequence[Sequence[Letter]]) -> Lasso | None:
        asked.append(Asked(problem, [list(letters) for letters in histories]))
        return replan(problem, histories)

    rig.planner.solver.replan = noting_replan  # type: ignore[method-assign]
    start = Asked(*rig.task.problem())
    rig.begin()
    rig.vehicle.payloads.answers = [(2.0, Failed("denied")), (1.0, Progress.DONE)]
    rig.run_until(PlaceReached, place="A", times=2)
    for _ in range(60):
        rig.tick()
    rig.tick(TARGET)
    rig.run_to_the_end()
    is_it_still_best, *after = asked
    assert "targetFound" in is_it_still_best.problem.facts and len(after) == 2
    return [start, *after]


def asked_of(
    engine: str, asked: Problem, encoding: Encoding = V4, timeout_s: float = LIMIT_S
) -> Solution | None:
    """What an engine answers at the first position."""
    return solve_with(asked, history(asked), engine, encoding, Objective.SUM, timeout_s)


def best_ms(asked: Problem, objective: Objective) -> int:
    *_, solution = Search().solutions(asked, objective)
    return solution.cost_ms


PLANNED = {
    *((0, V4, Objective.SUM), (1, V1, Objective.SUM), (2, V5, Objective.SUM)),
    (1, V4, Objective.LAP),
}
"""Phases, encodings and objectives of every run; all of them with the sweeps."""


@pytest.mark.slow
@pytest.mark.parametrize(
    ("phase", "encoding", "objective"),
    [
        pytest.param(*case, marks=[] if case in PLANNED else [pytest.mark.long])
        for case in itertools.product(range(3), Encoding, (Objective.SUM, Objective.LAP))
    ],
)
def test_the_paper_s_three_plans(
    phases: list[Asked], phase: int, encoding: Encoding, objective: Objective
) -> None:
    asked = phases[phase]
    found = solve_with(*asked, "fast-downward", encoding, objective, LIMIT_S)
    assert found is not None
    assert fault(asked.problem, found.lasso, asked.histories) is None
    assert found.engine == f"fast-downward {encoding}"
    assert not found.is_optimal  # a loop need not lead the automata back at once
    if encoding is V1:
        assert found.cost_ms >= best_ms(asked.problem, objective)
    else:
        assert found.cost_ms == best_ms(asked.problem, objective)


@pytest.mark.slow
@pytest.mark.parametrize(
    "phase", [0, *(pytest.param(phase, marks=pytest.mark.long) for phase in (1, 2))]
)
def test_a_second_planner_agrees_that_there_is_a_plan(phases: list[Asked], phase: int) -> None:
    found = solve_with(*phases[phase], "pyperplan", V5, Objective.SUM, LIMIT_S)
    assert found is not None and not found.is_optimal
    assert found.engine == "pyperplan v5"
    assert found.cost_ms >= best_ms(phases[phase].problem, Objective.SUM)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("task", "encoding"),
    [
        pytest.param(task, encoding, marks=[pytest.mark.long] if (i + 4 * j) % 6 else [])
        for i, task in enumerate(TASKS)
        for j, encoding in enumerate(Encoding)
    ],
)
def test_small_tasks(task: str, encoding: Encoding) -> None:
    costs = {p: 2.0 + i for i, p in enumerate(itertools.permutations("HAB", 2))}
    asked = problem("HAB", costs, task)
    found = solve_with(asked, history(asked), "fast-downward", encoding, Objective.SUM, LIMIT_S)
    assert found is not None
    if encoding is V1:
        assert found.cost_ms >= best_ms(asked, Objective.SUM)
    else:
        assert found.cost_ms == best_sum(asked)
        assert not found.bound_ms


@pytest.mark.long
@pytest.mark.parametrize("task", TASKS)
def test_small_tasks_by_a_second_planner(task: str) -> None:
    asked = problem("HAB", unit_costs("HAB"), task)
    assert solve_with(asked, history(asked), "pyperplan", V5, Objective.SUM, LIMIT_S) is not None


# -- No plan, and no answer ------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize(
    ("task", "encoding"),
    [
        *(("G at(H) & F at(A)", encoding) for encoding in Encoding),
        *(pytest.param("false", encoding, marks=pytest.mark.long) for encoding in (V1, V5)),
        ("false", V4),
    ],
)
def test_that_there_is_no_plan_is_proved(task: str, encoding: Encoding) -> None:
    asked = problem("HA", unit_costs("HA"), task)
    found = solve_with(asked, history(asked), "fast-downward", encoding, Objective.LAP, LIMIT_S)
    assert found is None


def test_a_missing_engine_is_named_with_what_brings_it() -> None:
    asked = problem("HA", unit_costs("HA"), "G F at(A)")
    with pytest.raises(EngineError, match="lpg is not installed; pip install up-lpg"):
        asked_of("lpg", asked)
    with pytest.raises(EngineError, match=r"no engine downwards; installed are: .*fast-downward"):
        asked_of("downwards", asked)
    assert EngineError.exit_code == 1 and issubclass(EngineError, CompanionError)


def test_an_engine_that_cannot_take_the_encoding_is_told_which_it_can() -> None:
    asked = problem("HA", unit_costs("HA"), "G F at(A) & G !at(B)")
    with pytest.raises(EngineError, match=r"pyperplan cannot take encoding v4.*use encoding v5"):
        asked_of("pyperplan", asked)


@pytest.mark.slow
@pytest.mark.parametrize(
    "engine", ["fast-downward", pytest.param("pyperplan-opt", marks=pytest.mark.long)]
)
def test_an_engine_that_takes_too_long_is_ended(engine: str) -> None:
    places = "HABCDEFGIJKLMN"
    costs = {pair: 2.0 + i % 17 for i, pair in enumerate(itertools.permutations(places, 2))}
    task = " & ".join(f"G F at({place})" for place in places)
    with pytest.raises(EngineError, match=f"{engine} did not answer in 2 s"):
        asked_of(engine, problem(places, costs, task), V5, 2.0)
    assert not multiprocessing.active_children()


@pytest.mark.slow
def test_calls_at_the_same_time_do_not_disturb_each_other(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """Fast Downward hands its translation on in a file; it is never where the caller is."""
    monkeypatch.chdir(tmp_path)
    tasks = ["G F at(A)", "G F at(B)", "G F at(A) & G F at(B)", "F G at(A)"]
    asked = [problem("HAB", unit_costs("HAB"), task) for task in tasks]

    def found(one: Problem) -> int | None:
        plan = solve_with(one, history(one), "fast-downward", V4, Objective.SUM, LIMIT_S)
        return plan.cost_ms if plan is not None else None

    with ThreadPoolExecutor(len(asked)) as pool:
        costs = list(pool.map(found, asked))
    assert costs == [best_ms(one, Objective.SUM) for one in asked]
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("loop", "told"),
    [("wait", "the plan's word does not"), ("dance", "an action that the task has not")],
)
def test_a_wrong_plan_is_reported(monkeypatch: pytest.MonkeyPatch, loop: str, told: str) -> None:
    asked = problem("HA", unit_costs("HA"), "G F at(A)")
    answer = EngineAnswer("SOLVED_OPTIMALLY", (), (loop,))
    monkeypatch.setattr("companion.planning.engines._asked", lambda *_: answer)
    with pytest.raises(CompanionError, match=f"fast-downward made a wrong plan, .*: {told}"):
        asked_of("fast-downward", asked)


def test_nothing_is_printed(capfd: pytest.CaptureFixture[str]) -> None:
    asked = problem("HA", unit_costs("HA"), "G F at(A)")
    for engine in ("fast-downward", "pyperplan"):
        assert solve_with(asked, history(asked), engine, V5, Objective.SUM, LIMIT_S)
    assert capfd.readouterr().out == ""


@pytest.mark.slow
@pytest.mark.parametrize("encoding", [V1, V4])
def test_conditional_effects_of_skills_reach_the_planner(encoding: Encoding) -> None:
    lamp, none = facts_of("lamp"), facts_of()
    flips = (ConditionalEffect(lamp, none, none, lamp), ConditionalEffect(none, lamp, lamp, none))
    asked = problem(
        "HA",
        unit_costs("HA"),
        "G F lamp & G F !lamp & X !lamp",
        extra=(action("switch", conditional=flips),),
    )
    found = solve_with(asked, history(asked), "fast-downward", encoding, Objective.LAP, LIMIT_S)
    assert found is not None
    assert [a.name for a in found.lasso.loop] == ["switch", "switch"]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("child", "told"),
    [
        (bad_engines.killed, r"fast-downward failed \(INTERNAL_ERROR\)"),
        (bad_engines.eating, "fast-downward ran out of memory"),
        pytest.param(  # an engine that takes too long is ended above, too
            bad_engines.spinning, "fast-downward did not answer in 3 s", marks=pytest.mark.long
        ),
        (bad_engines.deaf, "fast-downward did not answer in 3 s"),
    ],
)
def test_a_bad_engine_is_told_and_the_next_call_has_a_new_child(
    monkeypatch: pytest.MonkeyPatch, child: Callable[..., None], told: str
) -> None:
    asked = problem("HA", unit_costs("HA"), "G F at(A)")
    limit_s = 3.0 if "3 s" in told else LIMIT_S
    with monkeypatch.context() as patched:
        patched.setattr(engine_process, "run", child)
        with pytest.raises(EngineError, match=told):
            asked_of("fast-downward", asked, timeout_s=limit_s)
    assert not multiprocessing.active_children()
    assert solve_with(asked, history(asked), "fast-downward", V4, Objective.LAP, LIMIT_S)


@pytest.mark.slow
def test_a_task_that_is_too_large_to_be_compiled_fills_the_engine_s_process_alone(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(engines, "EngineQuestion", bad_engines.TooLarge)
    with pytest.raises(EngineError, match="fast-downward ran out of memory; use another encoding"):
        asked_of("fast-downward", problem("HA", unit_costs("HA"), "G F at(A)"))
    assert not multiprocessing.active_children()


def test_what_an_encoding_cannot_express_is_told_by_the_engine_s_process() -> None:
    places = "HABCDEFGIJKLMNOPQRST"
    asked = problem(places, unit_costs(places), " & ".join(f"G F at({p})" for p in places))
    with pytest.raises(EngineError, match="the automaton would take more than"):
        asked_of("fast-downward", asked, V1)


@pytest.mark.long
@pytest.mark.slow
def test_the_server_of_the_children_is_started_again_when_it_has_died() -> None:
    asked = problem("HA", unit_costs("HA"), "G F at(A)")
    assert asked_of("fast-downward", asked)
    server = forkserver._forkserver._forkserver_pid  # type: ignore[attr-defined]
    os.kill(server, signal.SIGKILL)
    os.waitid(os.P_PID, server, os.WEXITED | os.WNOWAIT)
    assert asked_of("fast-downward", asked)


@pytest.mark.parametrize("error", [EOFError, BrokenPipeError, ConnectionRefusedError])
def test_a_server_that_dies_as_it_is_asked_is_an_engine_that_has_failed(
    monkeypatch: pytest.MonkeyPatch, error: type[Exception]
) -> None:
    def start(child: object) -> None:
        raise error

    monkeypatch.setattr("multiprocessing.context.ForkServerProcess.start", start)
    asked = problem("HA", unit_costs("HA"), "G F at(A)")
    with pytest.raises(EngineError, match=r"fast-downward failed \(INTERNAL_ERROR\)"):
        asked_of("fast-downward", asked)
