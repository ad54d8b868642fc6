"""Chooses which lines of a task a plan keeps if it cannot keep all of them.

Lines without a priority are never dropped. The others are added one by one, the most important one
first, and each is kept if a plan remains. So no line is given up for less important ones, however
many these are (lexicographic, greedy). If all lines can be kept, one search tells; otherwise there
are at most two more searches than optional lines.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence

from companion.planning.explain import IsSolvable
from companion.planning.lasso import DroppedLine, Letter, Problem

NO_PLAN = "no plan keeps it"
NOT_KNOWN = "the search for a plan that keeps it was given up"

Histories = Sequence[Sequence[Letter]]
"""Per conjunct, the letters that it has read."""


def without_lines(
    lines: Collection[str], problem: Problem, histories: Histories = ()
) -> tuple[Problem, list[Sequence[Letter]]]:
    """A problem without some lines of its task, and the histories of the remaining conjuncts."""
    if not lines:
        return problem, list(histories)
    kept = [i for i, conjunct in enumerate(problem.conjuncts) if conjunct.name not in lines]
    return problem.only(kept), [histories[i] for i in kept if histories]


def select(
    problem: Problem, optional: Sequence[str], is_solvable: IsSolvable
) -> tuple[DroppedLine, ...]:
    """The lines to drop.

    If there is no plan even for the lines that are never dropped, all others are dropped.

    Args:
        problem: the problem with all lines.
        optional: lines that may be dropped, the most important one first.
        is_solvable: the search.
    """
    whole = is_solvable(problem) if optional else True
    if whole:
        return ()
    reasons = dict.fromkeys(optional, NO_PLAN)
    dropped = list(optional)
    if is_solvable(without_lines(dropped, problem)[0]):
        for line in optional:
            rest = [other for other in dropped if other != line]
            found = is_solvable(without_lines(rest, problem)[0]) if rest else whole
            if found:
                dropped = rest
            elif found is None:
                reasons[line] = NOT_KNOWN
    return tuple(DroppedLine(line, reasons[line]) for line in dropped)


def line_to_take_up(
    problem: Problem, optional: Sequence[str], dropped: Collection[str], is_solvable: IsSolvable
) -> str | None:
    """The most important dropped line that can be kept now; None if there is none.

    To keep it, less important lines may be dropped.

    Args:
        problem: the problem with all lines.
        optional: lines that may be dropped, the most important one first.
        dropped: the lines among them that are dropped now.
        is_solvable: the search.
    """
    for number, line in enumerate(optional):
        if line in dropped:
            kept = {line, *(other for other in optional[:number] if other not in dropped)}
            left_out = [other for other in optional if other not in kept]
            if is_solvable(without_lines(left_out, problem)[0]):
                return line
    return None
