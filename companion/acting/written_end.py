"""Decides the outcome of a finished tree written by hand: its success alone satisfies no task."""

from __future__ import annotations

from companion.errors import NoPlanError
from companion.ltl.semantics import holds
from companion.planning.task_state import TaskState


def failure_at_the_end(task: TaskState) -> NoPlanError | None:
    """Why the task is not satisfied if the vehicle rests for ever; None if it is satisfied.

    Args:
        task: the task, after its last position was left.
    """
    said = []
    if violated := task.violated:
        said.append(f"has violated {', '.join(violated)}")
    if unmet := [line for line in _unmet_at_rest(task) if line not in violated]:
        said.append(f"has not met {', '.join(unmet)}")
    return NoPlanError(f"the tree is done, and {' and '.join(said)}") if said else None


def _unmet_at_rest(task: TaskState) -> list[str]:
    """The lines that must hold, and do not if the last letter repeats for ever.

    A line that has read nothing, because it started again after that letter, reads what holds where
    the vehicle is.
    """
    problem, histories = task.problem()
    unmet = dict.fromkeys(
        conjunct.name
        for conjunct, letters in zip(problem.conjuncts, histories, strict=True)
        if conjunct.name not in task.lines.optional
        and not holds(conjunct.formula, letters[:-1], letters[-1:] or [task.all_facts])
    )
    return list(unmet)
