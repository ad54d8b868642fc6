"""What acting sees of a planner from outside: it plans beside the flight loop, never in it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

from companion.planning.lasso import Lasso, Letter, Problem


@dataclass(frozen=True, slots=True)
class EngineFailure:
    """Why an engine has no plan; the built-in search is asked then.

    Attributes:
        reason: in words, with the engine's name.
    """

    reason: str


class EngineJob(Protocol):
    """A problem that an engine works on."""

    def answer(self, now_s: float) -> Lasso | EngineFailure | None:
        """The plan, or why there is none; None while it is not known.

        Raises:
            EngineTimeout: in lockstep, where a time limit must not decide on what is flown.
        """

    def abandon(self) -> None:
        """Nobody waits for the answer any more."""


class Engine(Protocol):
    """A planner from outside."""

    def plan(
        self, problem: Problem, histories: Sequence[Sequence[Letter]]
    ) -> Lasso | EngineFailure:
        """The plan before a flight, where it is waited for.

        Raises:
            EngineError: it cannot plan this mission, or is not installed.
            EngineTimeout: as an answer does.
        """

    def begin(
        self, problem: Problem, histories: Sequence[Sequence[Letter]], now_s: float
    ) -> EngineJob:
        """Begins to plan. It may not block."""
