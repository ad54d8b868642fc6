"""A step between two states of a product, with its cost, time and energy."""

from __future__ import annotations

from typing import NamedTuple


class TimedStep(NamedTuple):
    """An edge of a product between two of its states.

    Attributes:
        action: number of its action.
        cost_ms: its cost in the objective.
        duration_ms: its duration; for rest that is more than its cost.
        end: the state where it ends, as the number of the state's first node.
        node: the node where it ends.
        drain: the energy that it takes, if plans consider energy.
        charge: the least level from which, and the level to which, it charges; None if it does not.
    """

    action: int
    cost_ms: int
    duration_ms: int
    end: int
    node: int
    drain: int = 0
    charge: tuple[int, int] | None = None
