"""Constructs the graph of one formula without splitting it; labels are sets of letters.

1. The formula is unfolded (`tableau.py`), and the graph is reduced (`reductions/`).
2. A language with a weak deterministic automaton gets the smallest of these, unless it is larger.
3. The graph of G F a is also made from automata of F a (`reductions/recurrence.py`).
4. If the graph is nondeterministic, the formula is also unfolded letter by letter.

The smallest graph is the result.
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
"""A graph with more states than this is taken without trying other constructions."""


@dataclass(frozen=True, slots=True)
class Constructed:
    """A graph; if it is weak and deterministic, it is the smallest possible one."""

    graph: LabelledGraph[LetterSet]
    is_weak: bool


@dataclass(frozen=True, slots=True)
class Construction:
    """Constructs graphs of simplified formulas over one alphabet.

    Attributes:
        max_states: most states of a tableau, and most transitions of one of its states.
        budget: for the work that is necessary.
        extra: for the work that is optional.
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
        """Other graphs of a formula: restarting ones for G F a, otherwise a more deterministic one.

        Args:
            graph: the graph that is known already.
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
