"""Which automaton accepts exactly the words that satisfy a formula?

The formula is simplified (`simplify.py`), unfolded (`tableau.py`), and the automaton reduced. If
the letters are few, labels become sets of letters (`letters.py`); this finds smaller automata in
three ways, and the smallest is taken:

- reductions that look at each letter (`quotient.py`);
- the minimal weak deterministic automaton, if the language has one (`obligations.py`);
- of a conjunction, conjuncts that have such an automaton apart from the others.

Otherwise labels stay cubes (`reduction.py`).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial, reduce

from companion.ltl.automaton import BuchiAutomaton
from companion.ltl.budget import Budget, TranslationLimit
from companion.ltl.formula import (
    FALSE,
    TRUE,
    Formula,
    Operator,
    atoms,
    conjoin,
    negate,
    negation_normal_form,
    release,
)
from companion.ltl.letters import Alphabet, automaton_of, with_cubes, with_letters
from companion.ltl.obligations import conjoined, weak_deterministic
from companion.ltl.quotient import is_deterministic, smallest
from companion.ltl.reduction import Graph, pruned, reduced
from companion.ltl.simplify import simplified
from companion.ltl.tableau import unfolded

MAX_STATES = 10_000

MAX_STATES_AGAIN = 100
"""States up to which other automata of the same formula are made, to take the smallest."""

LEAST_STEPS = 25_000
"""What the smallest formula takes; it counts where one budget is for thousands of conjuncts."""

EXTRA_STEPS = 12_000_000
EXTRA_BYTES = 100_000_000
"""What may be spent on making an automaton smaller; then it is taken as it is."""


def translate(
    formula: Formula,
    *,
    exclusive: frozenset[str] = frozenset(),
    max_states: int = MAX_STATES,
    budget: Budget | None = None,
) -> BuchiAutomaton:
    """An automaton that accepts exactly the words that satisfy a formula.

    State 0 is its only initial state. From every other state some word is accepted.

    >>> from companion.ltl.parser import parse
    >>> automaton = translate(parse("G F p"))
    >>> automaton.states, [(str(t.label), set(t.marks)) for t in automaton.transitions]
    (1, [('p', {0}), ('!p', set())])

    Args:
        exclusive: propositions of which at most one holds at a time; what the automaton does with
            letters that have two of them is left open.
        max_states: states, and transitions of one state, that may be made before reduction.
        budget: what may be spent; a new one by default.

    Raises:
        TranslationLimit: `max_states` or the budget does not suffice.
    """
    normal = negation_normal_form(formula)
    alphabet = Alphabet(sorted(atoms(normal)), exclusive)
    budget = budget or Budget()
    budget.spend(LEAST_STEPS)
    translator = _Translator(alphabet, max_states, budget, Budget(EXTRA_STEPS, EXTRA_BYTES))
    return automaton_of(translator.cubes(simplified(normal, budget)), alphabet, str(formula))


@dataclass(frozen=True, slots=True)
class _Found:
    """A graph with sets of letters as labels; minimal if it is weak and deterministic."""

    graph: Graph
    is_weak: bool


@dataclass(frozen=True, slots=True)
class _Translator:
    """Makes graphs of simplified formulas over one alphabet.

    Attributes:
        budget: for what must be done.
        extra: for what need not be done.
    """

    alphabet: Alphabet
    max_states: int
    budget: Budget
    extra: Budget

    def cubes(self, formula: Formula) -> Graph:
        """The smallest graph that is found, with cubes as labels."""
        if self.alphabet.is_small:
            return with_cubes(self._smallest(formula), self.alphabet, self.budget)
        rough = self._unfolded(formula, self.budget)
        self.budget.keep(3 * rough.size[1])  # they are all there at once in several forms
        return pruned(rough) if rough.is_large else reduced(rough)

    def _unfolded(self, formula: Formula, budget: Budget) -> Graph:
        names, exclusive = self.alphabet.names, self.alphabet.exclusive
        return unfolded(formula, names, exclusive, self.max_states, budget)

    def _smallest(self, formula: Formula) -> Graph:
        """Conjuncts that share no proposition are translated apart and multiplied."""
        graphs = [self._parted(group) for group in self._independent(formula)]
        whole = reduce(partial(conjoined, budget=self.budget), graphs)
        if len(graphs) == 1 or all(map(is_deterministic, graphs)):
            return pruned(whole)  # there is nothing more to merge
        return smallest(whole, self.extra)

    def _independent(self, formula: Formula) -> list[Formula]:
        """Formulas whose conjunction is the given one, and that share no proposition."""
        groups: list[tuple[frozenset[str], list[Formula]]] = []
        for part in _conjuncts(formula, self.budget):
            names, together = atoms(part), [part]
            if names & self.alphabet.exclusive:
                names |= self.alphabet.exclusive
            for group in [known for known in groups if known[0] & names]:
                groups.remove(group)
                names, together = names | group[0], group[1] + together
            groups.append((names, together))
        return [simplified(conjoin(*together), self.budget) for _, together in groups]

    def _parted(self, formula: Formula) -> Graph:
        """The smaller graph: of all conjuncts, or with those that are obligations apart."""
        whole = self._whole(formula)
        if whole.is_weak or not 1 < len(whole.graph.edges) <= MAX_STATES_AGAIN:
            return whole.graph
        try:
            product = replace(self, budget=self.extra)._product(_conjuncts(formula, self.extra))
        except TranslationLimit:
            return whole.graph
        return min(whole.graph, product or whole.graph, key=lambda graph: len(graph.edges))

    def _product(self, parts: list[Formula]) -> Graph | None:
        """The graph of obligations and of other conjuncts; None if all are of one kind."""
        is_weak = {part: self._whole(part).is_weak for part in parts} if parts[1:] else {}
        groups = [[part for part in is_weak if is_weak[part] is kind] for kind in (True, False)]
        if not all(groups):
            return None
        weak, other = (
            self._whole(simplified(conjoin(*group), self.budget)).graph for group in groups
        )
        return smallest(conjoined(weak, other, self.budget), self.extra)

    def _whole(self, formula: Formula) -> _Found:
        """A graph of a formula as it stands: minimal and deterministic, or reduced."""
        rough = with_letters(self._unfolded(formula, self.budget), self.alphabet, self.budget)
        graph = smallest(rough, self.extra)
        if len(graph.edges) == 1:
            return _Found(graph, not graph.marks)
        if len(graph.edges) <= MAX_STATES_AGAIN:
            weak = self._weak(formula, graph)
            if weak and len(weak.edges) <= len(graph.edges):
                return _Found(weak, True)
        return _Found(graph, False)

    def _weak(self, formula: Formula, graph: Graph) -> Graph | None:
        """The minimal weak deterministic automaton of a formula, if there is one."""

        def complement() -> Graph:
            opposite = simplified(negation_normal_form(negate(formula)), self.extra)
            rough = with_letters(self._unfolded(opposite, self.extra), self.alphabet, self.extra)
            return smallest(rough, self.extra)

        try:
            weak = weak_deterministic(graph, self.alphabet.every, complement, self.extra)
        except TranslationLimit:
            return None
        return weak and pruned(weak)


def _conjuncts(formula: Formula, budget: Budget) -> list[Formula]:
    """The conjuncts of a simplified formula, split at & and at G over &."""
    parts: list[Formula] = []
    for part in formula.operands if formula.operator is Operator.AND else (formula,):
        event, kept = part.operands if part.operator is Operator.RELEASE else (TRUE, part)
        if event is FALSE and kept.operator is Operator.AND:
            parts += [release(FALSE, operand) for operand in kept.operands]
        else:
            parts.append(part)
    return [simplified(part, budget) for part in parts]
