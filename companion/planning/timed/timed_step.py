"""A step between two states of a product, with what it takes."""

from __future__ import annotations

from typing import NamedTuple


class TimedStep(NamedTuple):
    """An edge of a product between two of its states.

    Attributes:
        action: its number.
        cost_ms: in the objective.
        duration_ms: what it takes; rest costs less than that.
        end: the state, as the number of its first node.
        node: the node where it ends.
        drain: what it takes of the battery, where plans know of one.
        charge: from which level at least to which one it charges; None where it does not.
    """

    action: int
    cost_ms: int
    duration_ms: int
    end: int
    node: int
    drain: int = 0
    charge: tuple[int, int] | None = None
