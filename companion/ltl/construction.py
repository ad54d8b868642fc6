"""Construction: the graph of one formula as it stands, with sets of letters as labels.

The formula is unfolded (`tableau.py`), and the graph reduced (`reductions/`). A language that has a
weak deterministic automaton gets the smallest of these, if that is no larger. G F a is also made
from automata of F a (`reductions/recurrence.py`), and what is not deterministic is unfolded letter
by letter as well; the smallest graph is taken.
"""

from __future__ import annotations

from dataclasses import dataclass

from companion.ltl.budget import Budget, TranslationLimit
from companion.ltl.formula import Formula, negate, negation_normal_form
from companion.ltl.graph import LabelledGraph, is_deterministic, with_letters
from companion.ltl.labels import Alphabet, LetterSet
from companion.ltl.reductions.recurrence import is_recurrence, restarted
from companion.ltl.reductions.strategy import reduced
from companion.ltl.reductions.trimming import trimmed
from companion.ltl.reductions.weak_determinisation import weak_deterministic
from companion.ltl.simplify import simplified
from companion.ltl.tableau import unfolded, unfolded_by_letters

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
            try:
                others = self._others(formula, graph)
            except TranslationLimit:
                others = []
            graph = min([graph, *others], key=lambda known: known.size)
        return Constructed(graph, False)

    def is_empty(self, formula: Formula) -> bool:
        """Whether no word satisfies a formula in negation normal form.

        Raises:
            TranslationLimit: the extra budget does not suffice.
        """
        graph = trimmed(self._rough(simplified(formula, self.extra), self.extra))
        return not graph.edges[0]

    def _others(
        self, formula: Formula, graph: LabelledGraph[LetterSet]
    ) -> list[LabelledGraph[LetterSet]]:
        """Other graphs of a formula: of G F a some that start again, else a more deterministic one.

        Args:
            graph: the one that is known.
        """
        if is_recurrence(formula):
            once = formula.operands[1]
            first = reduced(self._rough(once, self.extra), self.extra)
            found = [
                restarted(known, self.alphabet.every, overlaps)
                for known in (first, self._weak(once, first))
                for overlaps in (False, True)
                if known
            ]
        elif is_deterministic(graph):
            found = []
        else:
            found = [unfolded_by_letters(formula, self.alphabet, self.max_states, self.extra)]
        return [reduced(other, self.extra) for other in found if other]

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
