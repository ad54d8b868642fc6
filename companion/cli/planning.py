"""The command that plans without a vehicle, from any state: plan."""

from __future__ import annotations

import json
import time
from collections.abc import Sequence
from pathlib import Path
from textwrap import indent
from typing import TYPE_CHECKING, Annotated, Any

import typer

from companion.cli.arguments import MissionFile, load
from companion.cli.engine_options import BUILT_IN, EncodingOption, EngineOption
from companion.cli.log_lines import Verbose
from companion.cli.task_places import placed
from companion.errors import CompanionError, RequestError
from companion.planning.objective import Encoding, Objective

if TYPE_CHECKING:
    from companion.planning.lasso import Lasso, Letter, Problem, Solution
    from companion.planning.planner import Planner

FORMAT_VERSION = 1
"""Version of the JSON that `plan --json` and `check --json` print."""
TOLD_PERCENT = 0.1
"""A plan that may exceed the best one by less than this counts as the best."""


ObjectiveOption = Annotated[
    Objective,
    typer.Option(
        help="Which plan is best. lap: the one with the shortest lap, and of these the shortest "
        "prefix; sum: the least prefix and lap together; bottleneck: the shortest longest time "
        "between two fulfilments of a recurring part of the task."
    ),
]
EngineTimeout = Annotated[
    float, typer.Option(help="Let an engine plan for this many seconds at most.", min=0.1)
]
PddlFolder = Annotated[
    Path | None,
    typer.Option(metavar="DIR", help="Write the problem to this folder as PDDL, and do not plan."),
]
SetFacts = Annotated[
    list[str] | None, typer.Option("--set", metavar="FACT", help="Assume that this fact holds.")
]
UnsetFacts = Annotated[
    list[str] | None,
    typer.Option("--unset", metavar="FACT", help="Assume that this fact does not hold."),
]
Without = Annotated[
    list[str] | None,
    typer.Option(
        metavar="BELIEF", help="Assume that this belief is withdrawn, e.g. canUpload(r1)."
    ),
]


def plan(
    mission: MissionFile,
    at: Annotated[str | None, typer.Option(metavar="PLACE", help="Plan from this place.")] = None,
    holds: SetFacts = None,
    fails: UnsetFacts = None,
    without: Without = None,
    objective: ObjectiveOption = Objective.LAP,
    engine: EngineOption = BUILT_IN,
    encoding: EncodingOption = Encoding.V4,
    timeout: EngineTimeout = 60.0,
    pddl: PddlFolder = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON.")] = False,
    verbose: Verbose = False,
) -> None:
    """Prints the plan: a prefix that is flown once and a loop that is flown for ever.

    A plan assumes that no event changes. To ask "what if", use --at, --set,
    --unset and --without, e.g. --at A --set targetFound. If no plan keeps a line
    of the task that has a priority, the line is dropped, and the answer says why.
    """
    from companion.planning.explain import NoPlan

    planner = _planner(mission)
    facts = [*(holds or ()), *(f"!{fact}" for fact in fails or ())]
    problem, histories = planner.initial_problem(at=at, facts=facts, without=without or ())
    if planner.mission.tree:
        raise RequestError("the mission has a tree of its own, so there is nothing to plan")
    if pddl is not None:
        _write_pddl(planner, problem, histories, pddl, encoding, objective)
        return
    start_s = time.perf_counter()
    try:
        solution = planner.plan(
            at=at,
            facts=facts,
            without=without or (),
            objective=objective,
            engine=engine,
            encoding=encoding,
            timeout_s=timeout,
        )
    except NoPlan as reason:
        if as_json:
            nothing = dict.fromkeys(("prefix", "loop", "dropped"))
            asked = _as_json(planner, problem, time.perf_counter() - start_s)
            typer.echo(json.dumps(asked | nothing | {"reason": reason.explanation.as_json()}))
        raise placed(reason, mission) from reason
    if as_json:
        asked = _as_json(planner, problem, time.perf_counter() - start_s)
        typer.echo(json.dumps(asked | _solution_as_json(planner, problem, solution), indent=2))
    else:
        _print(planner, problem, solution)


def _print_dropped(planner: Planner, problem: Problem, solution: Solution) -> None:
    """Prints the lines of the task that a plan does not keep, and their conflicts."""
    from companion.planning.optional_lines import NO_PLAN

    for each in solution.dropped:
        typer.echo(f"dropped    {each}")
        if each.reason == NO_PLAN:
            why = planner.solver.why_dropped(problem, solution.dropped, each.line)
            typer.echo(indent(str(why).removeprefix("no plan: "), "  "))


def _planner(path: Path) -> Planner:
    """The planner of a mission file; it records the time that it took to make it."""
    from companion.planning.planner import Planner

    return Planner(load(path), clock=time.perf_counter)


def _print_steps(planner: Planner, problem: Problem, lasso: Lasso) -> None:
    """Prints prefix and loop: cost and energy of each action."""
    taken = planner.ledger(problem, lasso)
    actions = (*lasso.prefix, *lasso.loop)
    energies = ["" for _ in actions] if taken is None else map(str, (*taken.prefix, *taken.loop))
    lines = [
        f"  {action.name:<24} {action.cost_ms / 1000:6.1f} s   {energy}".rstrip()
        for action, energy in zip(actions, energies, strict=True)
    ]
    cut = len(lasso.prefix)
    typer.echo("\n".join(("prefix", *lines[:cut], "loop", *lines[cut:])))
    typer.echo(f"prefix {lasso.prefix_cost_ms / 1000:.1f} s, lap {lasso.lap_cost_ms / 1000:.1f} s")
    if taken is not None:
        typer.echo(f"energy {taken}")


def _print(planner: Planner, problem: Problem, solution: Solution) -> None:
    from companion.planning.time_check import waits

    _print_steps(planner, problem, solution.lasso)
    for wait in waits(problem, solution):
        typer.echo(f"waits  {wait}")
    what = f"{solution.objective} {solution.cost_ms / 1000:.1f} s"
    if solution.is_optimal:
        typer.echo(f"{what}, optimal ({solution.engine})")
    elif solution.cost_ms == solution.bound_ms:
        typer.echo(f"{what}, optimal; a shorter prefix is not ruled out ({solution.engine})")
    elif solution.bound_ms:
        over = 100 * (solution.cost_ms / solution.bound_ms - 1)
        is_best = over < TOLD_PERCENT
        quality = "the best to 0.1 %" if is_best else f"at most {over:.1f} % over the best"
        typer.echo(f"{what}, {quality} ({solution.engine})")
    else:
        typer.echo(f"{what}; how good that is, is not known ({solution.engine})")
    _print_dropped(planner, problem, solution)


def _solution_as_json(planner: Planner, problem: Problem, solution: Solution) -> dict[str, Any]:
    """The plan with its waits; with a battery, also with the energy of each step."""
    from companion.flight_events.writing import json_of
    from companion.planning.time_check import waits

    longest = {"waits": [wait.as_json() for wait in waits(problem, solution)]}
    taken = planner.ledger(problem, solution.lasso)
    if taken is None:
        return solution.as_json() | longest
    planned = solution.lasso.planned
    parts = (
        ("prefix", planned.prefix, taken.prefix),
        ("loop", planned.loop, taken.loop),
    )
    told: dict[str, Any] = {
        part: [
            json_of(step) | energy.as_json() for step, energy in zip(steps, energies, strict=True)
        ]
        for part, steps, energies in parts
    }
    return solution.as_json() | told | longest | {"energy": taken.as_json()}


def _write_pddl(
    planner: Planner,
    problem: Problem,
    histories: Sequence[Sequence[Letter]],
    folder: Path,
    encoding: Encoding,
    objective: Objective,
) -> None:
    """Writes the problem as two PDDL files, with the lines of the task that a plan keeps.

    Raises:
        CompanionError: the mission has a battery or time bounds, which the PDDL cannot express.
    """
    from companion.planning.compilation.encode import encode
    from companion.planning.compilation.monolithic import monolithic
    from companion.planning.compilation.pddl import to_pddl

    if problem.energy is not None:
        raise RequestError("PDDL is written without energy; remove battery: from the mission first")
    if problem.clocks_ms:
        raise RequestError(
            "PDDL is written without bounds in time; remove them from the task first"
        )
    problem, histories, _ = planner.solver.kept(problem, histories)
    if encoding is Encoding.V1:
        problem = monolithic(problem, histories)
    texts = to_pddl(encode(problem, encoding, objective))
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for name, text in zip(("domain.pddl", "problem.pddl"), texts, strict=True):
            (folder / name).write_text(text, encoding="utf-8")
            typer.echo(str(folder / name))
    except OSError as error:
        raise CompanionError(f"cannot write to {folder}: {error.strerror or error}") from error


def _as_json(planner: Planner, problem: Problem, search_s: float) -> dict[str, Any]:
    """The question and the effort of the answer, in JSON values."""
    seconds = {
        "translate": planner.translating_s,
        "ground": planner.instantiating_s,
        "search": search_s,
    }
    return {
        "version": FORMAT_VERSION,
        "mission": planner.mission.name,
        "times_ms": {name: round(1000 * passed, 3) for name, passed in seconds.items()},
        "automata": [
            {
                "conjunct": conjunct.name,
                "formula": conjunct.text,
                "states": conjunct.automaton.states,
                "transitions": len(conjunct.automaton.transitions),
                "marks": conjunct.automaton.marks,
            }
            for conjunct in planner.conjuncts
        ],
        "state": {
            "facts": sorted(problem.facts - planner.actions.model.beliefs),
            "withdrawn": sorted(problem.withdrawn),
            "automata": [sorted(states) for states in problem.automaton_states],
        },
    }
