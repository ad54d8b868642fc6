"""Problems with unread rises: events that have risen and fallen since the last letter.

Only the automata take them in. An automaton that mentions such an event begins in an extra state,
from which it reads the next letter as if the event held. Facts and actions do not contain the
event, so preconditions see what holds now. The problem is solved like any other one.
"""

from __future__ import annotations

from dataclasses import replace

from companion.ltl.first_letter import with_first_letter
from companion.mission.facts import Fact
from companion.planning.lasso import Conjunct, Problem
from companion.slices import spent

_TAKING_IN_US = 100


class UnreadRises:
    """Makes such problems, and keeps the automata from plan to plan."""

    def __init__(self) -> None:
        self._found: dict[tuple[str, str, frozenset[int], frozenset[Fact]], Conjunct] = {}

    def with_unread(self, problem: Problem, unread: frozenset[Fact]) -> Problem:
        """A problem whose first letter has these events, besides what the plan's facts give."""
        conjuncts, states = [], []
        for conjunct, own in zip(problem.conjuncts, problem.automaton_states, strict=True):
            mentioned = unread & conjunct.facts
            taken = self._with(conjunct, own, mentioned) if mentioned else conjunct
            conjuncts.append(taken)
            states.append(taken.automaton.initial if mentioned else own)
        return replace(
            problem, conjuncts=tuple(conjuncts), automaton_states=tuple(states), unread=unread
        )

    def _with(
        self, conjunct: Conjunct, states: frozenset[int], events: frozenset[Fact]
    ) -> Conjunct:
        key = (conjunct.name, conjunct.text, states, events)
        if key not in self._found:
            spent(_TAKING_IN_US)
            automaton = with_first_letter(conjunct.automaton, states, events)
            self._found[key] = replace(conjunct, automaton=automaton)
        return self._found[key]
