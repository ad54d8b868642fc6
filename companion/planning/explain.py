"""Why is there no plan? The conjuncts that conflict, and the withdrawn beliefs to blame.

A smallest conflicting set is found by deletion: drop one conjunct after the other for as long
as the rest still has no plan. If one withdrawn belief alone would make the task possible
again, it is named.
"""

from __future__ import annotations

from dataclasses import replace

from companion.planning.domain import Fact
from companion.planning.lasso import Problem
from companion.planning.search import find_lasso


def why_no_plan(problem: Problem) -> str:
    """The reason, in words, why a problem has no plan."""
    core = _conflict(problem)
    names = list(dict.fromkeys(problem.conjuncts[i].name for i in core))
    together = " together" if len(core) > 1 else ""
    lines = [f"no plan: {', '.join(names)} cannot hold{together} from here."]
    lines += [f"  {problem.conjuncts[i].name}: {problem.conjuncts[i].formula}" for i in core]
    withdrawn = sorted(problem.withdrawn)
    if withdrawn:
        lines.append(f"  withdrawn: {', '.join(withdrawn)}")
        blame = [b for b in withdrawn if _is_solvable(_with(problem, b))]
        if blame:
            lines.append(f"  with {' or '.join(blame)} there would be a plan")
    return "\n".join(lines)


def _conflict(problem: Problem) -> list[int]:
    """Indices of a smallest set (under inclusion) of conjuncts without a plan."""
    core = list(range(len(problem.conjuncts)))
    for i in tuple(core):
        rest = [j for j in core if j != i]
        if not _is_solvable(_only(problem, rest)):
            core = rest
    return core


def _only(problem: Problem, indices: list[int]) -> Problem:
    return replace(
        problem,
        conjuncts=tuple(problem.conjuncts[i] for i in indices),
        automaton_states=tuple(problem.automaton_states[i] for i in indices),
    )


def _with(problem: Problem, belief: Fact) -> Problem:
    return replace(problem, facts=problem.facts | {belief})


def _is_solvable(problem: Problem) -> bool:
    return find_lasso(problem) is not None
