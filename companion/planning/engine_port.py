"""The interface of planners from outside, for acting: they plan beside the flight loop."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

from companion.outcomes import Failed
from companion.planning.lasso import Lasso, Letter, Problem


class EngineJob(Protocol):
    """A problem that an engine works on."""

    def answer(self, now_s: float) -> Lasso | Failed | None:
        """The plan, or why there is none; None while the engine works.

        Raises:
            EngineTimeout: in lockstep, where a time limit must not decide what is flown.
        """

    def abandon(self) -> None:
        """Nobody waits for the answer any longer."""


class Engine(Protocol):
    """A planner from outside."""

    def plan(self, problem: Problem, histories: Sequence[Sequence[Letter]]) -> Lasso | Failed:
        """The plan before a flight; the caller waits for it.

        Raises:
            EngineError: the engine cannot plan this mission, or is not installed.
            EngineTimeout: as in `EngineJob.answer`.
        """

    def begin(
        self, problem: Problem, histories: Sequence[Sequence[Letter]], now_s: float
    ) -> EngineJob:
        """Begins to plan. It must not block."""
