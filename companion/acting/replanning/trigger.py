"""The rows of the table of replan triggers."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Generic, TypeVar

Subject = TypeVar("Subject")


@dataclass(frozen=True, slots=True)
class ReplanTrigger(Generic[Subject]):
    """One reason to plan again.

    Attributes:
        name: what is noticed.
        reason: why a new plan is due, in words for people; None if it is not.
    """

    name: str
    reason: Callable[[Subject], str | None]
