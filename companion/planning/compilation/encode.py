"""The encodings of a task as a classical planning problem, by name.

A plan of least cost is the best lasso. The objective is the sum of prefix and one lap (each action
at its own cost), or first the lap and then the prefix (then actions in the loop cost so much more
that no prefix outweighs a shorter lap).
"""

from __future__ import annotations

from companion.errors import RequestError
from companion.planning.compilation.classical import ClassicalProblem
from companion.planning.compilation.conditional import ConditionalEncoding
from companion.planning.compilation.decomposed import parts
from companion.planning.compilation.paper import encode_paper
from companion.planning.compilation.reduced_task import reduced_task
from companion.planning.compilation.strips import StripsEncoding
from companion.planning.lasso import Problem
from companion.planning.objective import Encoding, Objective

AUXILIARY_FACTS = frozenset(
    "BAstart BAturn LpS actTurn currBA deadBA end endBA endDone inLp inPrefix keepLp matchLp "
    "mv1Done not nreq nxtBA req reqLp seenBA".split()
)
AUXILIARY_ACTIONS = frozenset("actEnd actLoop mvBA mvBA1 mvBA2 startBA".split())


def encode(
    problem: Problem, encoding: Encoding, objective: Objective = Objective.SUM
) -> ClassicalProblem:
    """A problem as a classical planning problem.

    Args:
        problem: a problem; for v1, with one state-based automaton, as `monolithic` makes it.
        encoding: name of the encoding.
        objective: `LAP` or `SUM`.

    Raises:
        RequestError: the encoding cannot express the objective or an action, or a fact or an action
            has the name of an auxiliary one.
    """
    if objective is Objective.BOTTLENECK:
        raise RequestError(
            "a classical planner cannot minimise the bottleneck; "
            "use the built-in engine, or the objective lap or sum"
        )
    _check_names(problem)
    if encoding is Encoding.V1:
        return encode_paper(problem, objective)
    task = reduced_task(problem)
    decomposed = ConditionalEncoding if encoding is Encoding.V4 else StripsEncoding
    return decomposed(task, tuple(parts(problem, task)), objective).problem()


def _check_names(problem: Problem) -> None:
    facts = problem.facts.union(*(a.adds | a.requires | a.forbids for a in problem.actions))
    skills = frozenset(action.skill for action in problem.actions)
    clashes = [
        *(fact for fact in sorted(facts) if fact.predicate in AUXILIARY_FACTS),
        *sorted(skills & AUXILIARY_ACTIONS),
    ]
    if clashes:
        raise RequestError(
            f"{clashes[0]} is what the compiled task calls something of its own; "
            "give it another name in the mission"
        )
