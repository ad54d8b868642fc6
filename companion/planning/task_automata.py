"""The conjuncts of a mission's task with their automata."""

from __future__ import annotations

import logging
from collections.abc import Iterator

from companion.ltl.budget import Budget, TranslationLimit
from companion.ltl.timed_formula import parts
from companion.ltl.translate import translate
from companion.mission.model import Mission
from companion.planning.lasso import Conjunct

MOST_OF_IT = 0.5
"""Share of the budget. If earlier lines have used more, the error says that there are too many
lines."""

log = logging.getLogger(__name__)


def translated(mission: Mission) -> Iterator[Conjunct]:
    """The automata of the task; all of them share one budget.

    Raises:
        TranslationLimit: the budget is not enough for a line.
    """
    budget = Budget.of_a_mission()
    for name, line in mission.task.items():
        before = budget.share
        for part, bound in parts(line):
            try:
                automaton = translate(part, budget=budget)
            except TranslationLimit as limit:
                if budget.share > 1 and before > MOST_OF_IT:
                    limit = limit.after_others(before)
                raise limit.located(mission.lines_at[name]) from None
            sizes = automaton.states, len(automaton.transitions), automaton.marks
            log.debug("automaton of %s: %d states, %d transitions, %d marks", name, *sizes)
            yield Conjunct(name, part, automaton, bound)
