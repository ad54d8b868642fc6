"""Which lines of a task a plan keeps, where it cannot keep all of them.

Lines without a priority are never dropped. The others are added to them one by one, from the most
important one on, and each is kept if a plan remains: a line is never given up for less important
ones, however many these are (lexicographic, greedy). Where all lines can be kept one search says
so; else there are at most two more than optional lines.
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
    """A problem without some lines of its task, and what the conjuncts of the others have read."""
    if not lines:
        return problem, list(histories)
    kept = [i for i, conjunct in enumerate(problem.conjuncts) if conjunct.name not in lines]
    return problem.only(kept), [histories[i] for i in kept if histories]


def select(
    problem: Problem, optional: Sequence[str], is_solvable: IsSolvable
) -> tuple[DroppedLine, ...]:
    """The lines to drop.

    Where there is no plan for the lines that are never dropped, all others are dropped.

    Args:
        problem: with all lines.
        optional: those that may be dropped, the most important one first.
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
    """The most important line that was dropped and can be kept now; None if there is none.

    It may be at the cost of less important ones.

    Args:
        problem: with all lines.
        optional: those that may be dropped, the most important one first.
        dropped: those of them that were.
        is_solvable: the search.
    """
    for number, line in enumerate(optional):
        if line in dropped:
            kept = {line, *(other for other in optional[:number] if other not in dropped)}
            left_out = [other for other in optional if other not in kept]
            if is_solvable(without_lines(left_out, problem)[0]):
                return line
    return None
