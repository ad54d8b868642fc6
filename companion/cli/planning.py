"""The commands that plan without a vehicle: check and plan."""

from __future__ import annotations

import json
import time
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from companion.cli.arguments import MissionFile, load
from companion.cli.log_lines import Verbose
from companion.errors import CompanionError
from companion.planning.objective import Encoding, Objective

if TYPE_CHECKING:
    from companion.planning.lasso import Letter, Problem, Solution
    from companion.planning.planner import Planner
    from companion.planning.supposition import Supposition

BUILT_IN = "built-in"
FORMAT_VERSION = 1
"""Of the JSON that `plan --json` and `check --json` print."""


def check(
    mission: MissionFile,
    within: Annotated[
        Path | None,
        typer.Option(
            metavar="DIR", help="Refuse a mission that needs files outside, as one from a stranger."
        ),
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON.")] = False,
    verbose: Verbose = False,
) -> None:
    """Reads, translates and plans a mission; needs no vehicle."""
    try:
        checked = _Checked.read(mission, within)
    except CompanionError as error:
        if as_json:
            refused = {"version": FORMAT_VERSION, "ok": False, "exit_code": error.exit_code}
            typer.echo(json.dumps(refused | {"error": str(error)}))
        raise
    if as_json:
        typer.echo(json.dumps({"version": FORMAT_VERSION, "ok": True} | checked.as_json()))
        return
    typer.echo(f"mission    {checked.mission}: places {' '.join(checked.places)}")
    for name, states in checked.states.items():
        typer.echo(f"task       {name}: {states} states")
    typer.echo(f"plan       {checked.plan}")
    typer.echo("ok")


def plan(
    mission: MissionFile,
    at: Annotated[str | None, typer.Option(help="Plan from this place.")] = None,
    holds: Annotated[
        list[str] | None, typer.Option("--set", metavar="FACT", help="A fact that holds.")
    ] = None,
    fails: Annotated[
        list[str] | None, typer.Option("--unset", metavar="FACT", help="A fact that does not.")
    ] = None,
    without: Annotated[
        list[str] | None,
        typer.Option(metavar="BELIEF", help="A belief that is withdrawn, e.g. canUpload(r1)."),
    ] = None,
    objective: Annotated[
        Objective,
        typer.Option(
            help="What is best: the shortest lap and to it the shortest prefix; the least sum of "
            "both; or the least worst time between two fulfilments of a recurring part."
        ),
    ] = Objective.LAP,
    engine: Annotated[
        str,
        typer.Option(
            metavar="NAME",
            help="Who plans: built-in, or an engine of unified-planning such as fast-downward "
            "or pyperplan (with --encoding v5).",
        ),
    ] = BUILT_IN,
    encoding: Annotated[
        Encoding,
        typer.Option(
            help="How engines and --pddl are told: v1 as in the paper, one automaton; v4 one "
            "automaton for each conjunct; v5 the same without conditional effects."
        ),
    ] = Encoding.V4,
    timeout: Annotated[
        float, typer.Option(help="Seconds that an engine may take.", min=0.1)
    ] = 60.0,
    pddl: Annotated[
        Path | None,
        typer.Option(metavar="DIR", help="Write the problem there as PDDL; do not plan."),
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON.")] = False,
    verbose: Verbose = False,
) -> None:
    """Prints the plan: a prefix that is flown once and a loop that is flown for ever.

    --at, --set, --unset and --without ask "what if", e.g. --at A --set targetFound.
    """
    from companion.planning.explain import NoPlan
    from companion.planning.supposition import Supposition

    supposed = Supposition(at, tuple(holds or ()), tuple(fails or ()), tuple(without or ()))
    question = _Question.read(mission, supposed)
    if question.planner.mission.tree:
        raise CompanionError("the mission has a tree of its own, so there is nothing to plan")
    if pddl is not None:
        question.write(pddl, encoding, objective)
        return
    start_s = time.perf_counter()
    try:
        solution = question.answer(objective, engine, encoding, timeout)
    except NoPlan as reason:
        if as_json:
            nothing = {"prefix": None, "loop": None, "reason": reason.explanation.as_json()}
            typer.echo(json.dumps(question.as_json(time.perf_counter() - start_s) | nothing))
        raise
    search_s = time.perf_counter() - start_s
    if as_json:
        answer = question.as_json(search_s) | solution.as_json()
        typer.echo(json.dumps(answer, indent=2))
    else:
        _print(solution)


def _print(solution: Solution) -> None:
    lasso = solution.lasso
    for title, actions in (("prefix", lasso.prefix), ("loop", lasso.suffix)):
        typer.echo(title)
        for action in actions:
            typer.echo(f"  {action.name:<24} {action.cost_ms / 1000:6.1f} s")
    typer.echo(f"prefix {lasso.prefix_cost_ms / 1000:.1f} s, lap {lasso.lap_cost_ms / 1000:.1f} s")
    what = f"{solution.objective} {solution.cost_ms / 1000:.1f} s"
    if solution.is_optimal:
        typer.echo(f"{what}, optimal ({solution.engine})")
    elif solution.bound_ms:
        over = 100 * (solution.cost_ms / solution.bound_ms - 1)
        typer.echo(f"{what}, at most {over:.1f} % over the best ({solution.engine})")
    else:
        typer.echo(f"{what}; how good that is, is not known ({solution.engine})")


@dataclass(frozen=True)
class _Checked:
    """What is told of a mission that can be flown.

    Attributes:
        states: of each conjunct's automaton.
    """

    mission: str
    places: tuple[str, ...]
    states: dict[str, int]
    plan: str

    @classmethod
    def read(cls, path: Path, within: Path | None) -> _Checked:
        """Plans a mission, all of whose files may have to be in a folder."""
        from companion.mission.files import files_of

        if within is not None:
            files_of(path, within)
        question = _Question.read(path)
        planner = question.planner
        tree = planner.mission.tree
        if tree is not None:
            planner.actions_of(tree)
        return cls(
            planner.mission.name,
            tuple(planner.mission.places),
            {c.name: c.automaton.states for c in planner.conjuncts},
            "a tree of its own" if tree else str(question.answer().lasso),
        )

    def as_json(self) -> dict[str, Any]:
        """The same for programs."""
        return {"mission": self.mission, "automata": self.states, "plan": self.plan}


@dataclass(frozen=True)
class _Question:
    """A planner, and the state to plan from."""

    planner: Planner
    problem: Problem
    histories: list[list[Letter]]

    @classmethod
    def read(cls, path: Path, supposed: Supposition | None = None) -> _Question:
        """From a mission's first state, or from a supposed one."""
        from companion.acting.task_state import TaskState
        from companion.planning.planner import Planner
        from companion.run import flight_times, route_map

        mission = load(path)
        planner = Planner(mission, flight_times(mission, route_map(mission)), time.perf_counter)
        task = TaskState(planner)
        if supposed is not None:
            task.facts, task.withdrawn = supposed.facts(planner), supposed.withdrawn(planner)
        return cls(planner, *task.problem())

    def answer(
        self,
        objective: Objective = Objective.LAP,
        engine: str = BUILT_IN,
        encoding: Encoding = Encoding.V4,
        timeout_s: float = 60.0,
    ) -> Solution:
        """The best solution of the built-in search, or what an engine finds."""
        planner, problem, histories = self.planner, self.problem, self.histories
        if engine != BUILT_IN:
            from companion.planning.engines import solve_with

            solution = solve_with(problem, histories, engine, encoding, objective, timeout_s)
            if solution is not None:
                return solution
        *_, best = planner.solutions(problem, histories, objective)  # or says why there is none
        if engine != BUILT_IN:
            raise CompanionError(f"{engine} says that there is no plan, but there is: {best.lasso}")
        return best

    def write(self, folder: Path, encoding: Encoding, objective: Objective) -> None:
        """The problem as PDDL, two files."""
        from companion.planning.compilation.encode import encode
        from companion.planning.compilation.monolithic import monolithic
        from companion.planning.compilation.pddl import to_pddl

        problem = self.problem
        if encoding is Encoding.V1:
            problem = monolithic(problem, self.histories)
        texts = to_pddl(encode(problem, encoding, objective))
        try:
            folder.mkdir(parents=True, exist_ok=True)
            for name, text in zip(("domain.pddl", "problem.pddl"), texts, strict=True):
                (folder / name).write_text(text, encoding="utf-8")
                typer.echo(str(folder / name))
        except OSError as error:
            raise CompanionError(f"cannot write to {folder}: {error.strerror or error}") from error

    def as_json(self, search_s: float) -> dict[str, Any]:
        """What was asked, and what it took to answer."""
        planner, problem = self.planner, self.problem
        seconds = {
            "translate": planner.translating_s,
            "ground": planner.grounding_s,
            "search": search_s,
        }
        return {
            "version": FORMAT_VERSION,
            "mission": planner.mission.name,
            "times_ms": {name: round(1000 * passed, 3) for name, passed in seconds.items()},
            "automata": [
                {
                    "conjunct": conjunct.name,
                    "formula": str(conjunct.formula),
                    "states": conjunct.automaton.states,
                    "transitions": len(conjunct.automaton.transitions),
                    "marks": conjunct.automaton.marks,
                }
                for conjunct in planner.conjuncts
            ],
            "state": {
                "facts": sorted(problem.facts - planner.model.beliefs),
                "withdrawn": sorted(problem.withdrawn),
                "automata": [sorted(states) for states in problem.automaton_states],
            },
        }
