"""Construction: the graph of one formula as it stands, with sets of letters as labels.

The formula is unfolded (`tableau.py`), and the graph reduced (`reductions/`). A language that has a
weak deterministic automaton gets the smallest of these, if that is no larger. G F a is also made
from the automaton of F a (`reductions/recurrence.py`).
"""

from __future__ import annotations

from dataclasses import dataclass

from companion.ltl.budget import Budget, TranslationLimit
from companion.ltl.formula import Formula, negate, negation_normal_form
from companion.ltl.graph import LabelledGraph, with_letters
from companion.ltl.labels import Alphabet, LetterSet
from companion.ltl.reductions.recurrence import is_recurrence, restarted
from companion.ltl.reductions.strategy import reduced
from companion.ltl.reductions.trimming import trimmed
from companion.ltl.reductions.weak_determinisation import weak_deterministic
from companion.ltl.simplify import simplified
from companion.ltl.tableau import unfolded

MAX_STATES_AGAIN = 100
"""States up to which other automata of the same formula are made, to take the smallest."""


@dataclass(frozen=True, slots=True)
class Constructed:
    """A graph; the smallest there is if it is weak and deterministic."""

    graph: LabelledGraph[LetterSet]
    is_weak: bool


@dataclass(frozen=True, slots=True)
class Construction:
    """Makes graphs of simplified formulas over one alphabet.

    Attributes:
        max_states: states, and transitions of one state, that a tableau may have.
        budget: for what must be done.
        extra: for what need not be done.
    """

    alphabet: Alphabet
    max_states: int
    budget: Budget
    extra: Budget

    def construct(self, formula: Formula) -> Constructed:
        """The graph of a formula: tableau, reductions, weak determinisation.

        Raises:
            TranslationLimit: `max_states` or the budget does not suffice.
        """
        graph = reduced(self._rough(formula, self.budget), self.extra)
        if len(graph.edges) == 1:
            return Constructed(graph, not graph.marks)
        if len(graph.edges) <= MAX_STATES_AGAIN:
            weak = self._weak(formula, graph)
            if weak and len(weak.edges) <= len(graph.edges):
                return Constructed(weak, True)
            if is_recurrence(formula):
                return Constructed(self._recurring(formula, graph), False)
        return Constructed(graph, False)

    def _recurring(
        self, formula: Formula, graph: LabelledGraph[LetterSet]
    ) -> LabelledGraph[LetterSet]:
        """The smallest graph of G F a: the one that is known, or one that starts again."""
        once = formula.operands[1]
        try:
            weak = self._weak(once, reduced(self._rough(once, self.extra), self.extra))
        except TranslationLimit:
            return graph
        if weak is None or len(weak.edges) == 1:
            return graph
        found = [reduced(restarted(weak, overlaps), self.extra) for overlaps in (False, True)]
        return min([graph, *found], key=lambda known: known.size)

    def _rough(self, formula: Formula, budget: Budget) -> LabelledGraph[LetterSet]:
        graph = unfolded(formula, self.alphabet, self.max_states, budget)
        return with_letters(graph, self.alphabet, budget)

    def _weak(
        self, formula: Formula, graph: LabelledGraph[LetterSet]
    ) -> LabelledGraph[LetterSet] | None:
        """The smallest weak deterministic automaton of a formula, if there is one."""

        def complement() -> LabelledGraph[LetterSet]:
            opposite = simplified(negation_normal_form(negate(formula)), self.extra)
            return reduced(self._rough(opposite, self.extra), self.extra)

        try:
            weak = weak_deterministic(graph, self.alphabet.every, complement, self.extra)
        except TranslationLimit:
            return None
        return weak and trimmed(weak)
