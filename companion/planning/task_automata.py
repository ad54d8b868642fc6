"""The conjuncts of a mission's task with their automata."""

from __future__ import annotations

from collections.abc import Iterator

from companion.errors import KeyPath
from companion.ltl.budget import Budget, TranslationLimit
from companion.ltl.timed_formula import parts
from companion.ltl.translate import translate
from companion.mission.model import Mission
from companion.planning.lasso import Conjunct


def translated(mission: Mission) -> Iterator[Conjunct]:
    """The automata of the task, for all of which there is one budget.

    Raises:
        TranslationLimit: it does not suffice for a line.
    """
    budget = Budget.of_a_mission()
    for name, line in mission.task.items():
        for part, bound in parts(line):
            try:
                yield Conjunct(name, part, translate(part, budget=budget), bound)
            except TranslationLimit as limit:
                raise limit.located(KeyPath(("task", name))) from None
