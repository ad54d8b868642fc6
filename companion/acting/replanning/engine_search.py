"""The search of an engine from outside, asked in each tick while the vehicle holds."""

from __future__ import annotations

from collections.abc import Sequence

from companion.planning.engine_port import Engine, EngineFailure, EngineJob
from companion.planning.lasso import Lasso, Letter, Problem


class EngineSearch:
    """Has an engine plan, one problem at a time.

    Args:
        engine: who plans.
    """

    def __init__(self, engine: Engine) -> None:
        self._engine = engine
        self._job: EngineJob | None = None

    def step(
        self, problem: Problem, histories: Sequence[Sequence[Letter]], now_s: float
    ) -> Lasso | EngineFailure | None:
        """The part of a tick; the answer when it is known. What is outdated is abandoned before."""
        if self._job is None:
            self._job = self._engine.begin(problem, histories, now_s)
        answer = self._job.answer(now_s)
        if answer is not None:
            self.abandon()
        return answer

    def abandon(self) -> None:
        """Nothing is searched any more."""
        if self._job is not None:
            self._job.abandon()
            self._job = None
