"""The objectives and encodings that a planner may be asked for.

They have a module of their own because the rest takes long to import.
"""

from __future__ import annotations

from enum import StrEnum

from companion.arguments import named


class Objective(StrEnum):
    """The cost that the best lasso minimises.

    LAP: the shortest lap, and for it the shortest prefix, because a mission that loops for ever
        pays the lap for ever. SUM: the least cost of prefix and one lap together, which is what a
        classical planner minimises on the paper's compilation. BOTTLENECK: the least worst-case
        time between two fulfilments of the same recurring part of the task (after Smith, Tumova,
        Belta and Rus, Optimal path planning for surveillance with temporal-logic constraints, IJRR
        2011).
    """

    LAP = "lap"
    SUM = "sum"
    BOTTLENECK = "bottleneck"


class Encoding(StrEnum):
    """How a problem is compiled for a classical planner.

    V1: the paper's compilation (Figs. 2-4), with one automaton for the whole task. V4: one
        automaton for each conjunct. V5: like V4, without conditional effects and negation.
    """

    V1 = "v1"
    V4 = "v4"
    V5 = "v5"


def asked_for(objective: str, encoding: str) -> tuple[Objective, Encoding]:
    """The objective and the encoding with these names.

    Raises:
        RequestError: one of them does not exist.
    """
    return named(Objective, objective, "objective"), named(Encoding, encoding, "encoding")
