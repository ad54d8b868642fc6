"""What every reason to plan again has in common."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Generic, TypeVar

from companion.acting.plan_under_way import PlanUnderWay
from companion.acting.replanning.replanner import ReplanReason
from companion.slices import Question

T = TypeVar("T")


class ReplanTrigger(ABC):
    """One reason to plan again."""

    @abstractmethod
    def guard(self, plan: PlanUnderWay) -> bool:
        """Whether to look closer; it is quick and changes nothing."""

    @abstractmethod
    def reason(self, plan: PlanUnderWay) -> ReplanReason | None:
        """Looks closer; returns why a new plan is due, or None if it is not."""


class SlicedTrigger(ReplanTrigger, Generic[T]):
    """A reason that is found in slices, during several ticks.

    Args:
        question: its question; None for one of its own.
    """

    def __init__(self, question: Question[T] | None = None) -> None:
        self._question = Question[T]() if question is None else question

    @property
    def is_thinking(self) -> bool:
        """Whether its question is not answered yet."""
        return self._question.is_open

    def abandon(self) -> None:
        """Drops its question, because the plan is no longer flown."""
        self._question.abandon()
