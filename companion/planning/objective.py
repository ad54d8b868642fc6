"""Objectives and encodings that a planner may be asked for.

They are kept apart from the rest, which takes long to import.
"""

from __future__ import annotations

from enum import StrEnum
from typing import TypeVar

from companion.errors import RequestError


class Objective(StrEnum):
    """The cost that the best lasso minimises.

    LAP: the shortest lap, and to it the shortest prefix; a mission that loops for ever pays the
    lap for ever. SUM: the least cost of prefix and one lap together, which is what a classical
    planner minimises on the paper's compilation. BOTTLENECK: the least worst time between two
    fulfilments of the same recurring part of the task (after Smith, Tumova, Belta and Rus,
    Optimal path planning for surveillance with temporal-logic constraints, IJRR 2011).
    """

    LAP = "lap"
    SUM = "sum"
    BOTTLENECK = "bottleneck"


class Encoding(StrEnum):
    """The compilation of a problem for a classical planner.

    V1: the paper's compilation (Figs. 2-4) with one automaton for the whole task. V4: one automaton
    for each conjunct. V5: as V4, without conditional effects and negation.
    """

    V1 = "v1"
    V4 = "v4"
    V5 = "v5"


E = TypeVar("E", bound=StrEnum)


def named(kind: type[E], name: str) -> E:
    """The one of a name.

    >>> named(Objective, "sum")
    <Objective.SUM: 'sum'>

    Raises:
        CompanionError: there is none.
    """
    if name not in [each.value for each in kind]:
        raise RequestError(f"no {kind.__name__.lower()} {name!r}; there are {', '.join(kind)}")
    return kind(name)
