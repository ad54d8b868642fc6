"""Which automaton accepts exactly the words that satisfy a formula?

A state is a set of obligations: formulas that must hold from the next position on. Expanding an
obligation splits it into what must hold now and what is left for later; an until can be
fulfilled now or postponed, and a run that postpones the same until for ever is wrong. So each
until has its mark, on all transitions that do not postpone it. The formula is simplified before
(`simplify.py`) and the automaton reduced afterwards (`reduction.py`).

A *term* is one way to meet a set of obligations, written as a set of bits in an int: literals
that must hold now (two bits a proposition), obligations for the next position, untils postponed.
A term that is a subset of another asks for less, so the other is superfluous.

Source: Couvreur, On-the-fly verification of linear temporal logic, FM 1999; Giannakopoulou and
Lerda, From states to transitions, FORTE 2002; Gastin and Oddoux, Fast LTL to Büchi automata
translation, CAV 2001, for merging states and dropping transitions on the fly.
"""

from __future__ import annotations

from functools import reduce
from operator import or_

from companion.errors import CompanionError
from companion.ltl.automaton import BuchiAutomaton, Label, Transition
from companion.ltl.formula import TRUE, Formula, Operator, atoms, negation_normal_form
from companion.ltl.reduction import Edge, Graph, indices, minimal, reduced
from companion.ltl.simplify import simplified

Term = int
"""A set of bits: literals, obligations, postponed untils. No bits: nothing is asked."""


class TranslationLimit(CompanionError):
    """The automaton of a formula would be too large."""


def translate(formula: Formula, max_states: int = 10_000) -> BuchiAutomaton:
    """An automaton that accepts exactly the words that satisfy a formula.

    State 0 is its only initial state. From every other state some word is accepted.

    >>> from companion.ltl.parser import parse
    >>> automaton = translate(parse("G F p"))
    >>> automaton.states, [(str(t.label), set(t.marks)) for t in automaton.transitions]
    (1, [('p', {0}), ('!p', set())])

    Raises:
        TranslationLimit: more than `max_states` states, or as many transitions of one state,
            would be made before reduction.
    """
    name = str(formula)
    tableau = _Tableau(simplified(negation_normal_form(formula)), max_states, name)
    graph = reduced(tableau.graph())
    labels = {edge.label: tableau.label(edge.label) for leaving in graph.edges for edge in leaving}
    transitions = tuple(
        Transition(source, labels[edge.label], edge.target, frozenset(indices(edge.marks)))
        for source, leaving in enumerate(graph.edges)
        for edge in leaving
    )
    return BuchiAutomaton(len(graph.edges), frozenset({0}), transitions, graph.marks, name)


class _Tableau:
    """Expands sets of obligations, starting from one formula in negation normal form."""

    def __init__(self, formula: Formula, limit: int, name: str) -> None:
        self._formula = formula
        self._limit = limit
        self._name = name
        self._literals: list[Formula] = []  # the lowest bits: p, !p, q, !q, ...
        for name in sorted(atoms(formula)):
            proposition = Formula(Operator.ATOM, (), name)
            self._literals += [proposition, Formula(Operator.NOT, (proposition,))]
        self._bit_of = {literal: 1 << i for i, literal in enumerate(self._literals)}
        self._literal_bits = (1 << len(self._literals)) - 1
        self._next_of: dict[Formula, Term] = {}
        self._obligation_of: dict[Term, Formula] = {}
        self._postponed_of: dict[Formula, Term] = {}
        self._terms_of: dict[Formula, list[Term]] = {}

    def graph(self) -> Graph:
        """The automaton; sets of obligations with equal terms are one state."""
        number_of: dict[tuple[Term, ...], int] = {}
        state_of: dict[Term, int] = {}
        pending: list[tuple[Term, ...]] = []

        def state(obligations: Term) -> int:
            if obligations not in state_of:
                terms = tuple(sorted(self._expand_all(obligations)))
                state_of[obligations] = number_of.setdefault(terms, len(number_of))
                if state_of[obligations] == len(pending):
                    pending.append(terms)
                    self._check(len(pending), "states")
            return state_of[obligations]

        state(self._obligations(self._formula))
        edges = []
        for terms in pending:  # grows while it is read
            edges.append([(term, state(self._left_for_later(term))) for term in terms])
        marks = {bit: 1 << i for i, bit in enumerate(self._postponed_of.values())}
        return Graph(
            [
                [
                    Edge(
                        term & self._literal_bits,
                        sum(mark for bit, mark in marks.items() if not term & bit),
                        target,
                    )
                    for term, target in leaving
                ]
                for leaving in edges
            ],
            len(marks),
        )

    def label(self, bits: Term) -> Label:
        """The literals of a term."""
        literals = [self._literals[i] for i in indices(bits & self._literal_bits)]
        return Label(
            frozenset(f.atom for f in literals if f.operator is Operator.ATOM),
            frozenset(f.operands[0].atom for f in literals if f.operator is Operator.NOT),
        )

    def _expand_all(self, obligations: Term) -> list[Term]:
        terms = [0]
        for index in indices(obligations):
            terms = self._product(terms, self._expand(self._obligation_of[1 << index]))
        return terms

    def _expand(self, formula: Formula) -> list[Term]:
        """The terms of a formula, those of its operands first."""
        pending = [formula]
        while pending:
            node = pending[-1]
            needed = () if node.operator in (Operator.NEXT, Operator.NOT) else node.operands
            missing = [operand for operand in needed if operand not in self._terms_of]
            if not missing:
                self._terms_of[pending.pop()] = self._terms(node)
            pending += missing
        return self._terms_of[formula]

    def _terms(self, node: Formula) -> list[Term]:
        """The terms of a formula whose operands have theirs: the expansion laws of LTL."""
        match node.operator, node.operands:
            case Operator.TRUE, _:
                return [0]
            case Operator.FALSE, _:
                return []
            case Operator.NEXT, (operand,):
                return [self._obligations(operand)]
            case Operator.AND, operands:
                return reduce(self._product, (self._terms_of[operand] for operand in operands))
            case Operator.OR, operands:
                return minimal({t for operand in operands for t in self._terms_of[operand]})
            case Operator.UNTIL, (before, event):
                postpone = self._obligations(node) | self._postponed(node)
                later = self._product(self._terms_of[before], [postpone])
                return minimal({*self._terms_of[event], *later})
            case Operator.RELEASE, (event, kept):
                ways = minimal({*self._terms_of[event], self._obligations(node)})
                return self._product(self._terms_of[kept], ways)
        return [self._bit_of[node]]

    def _product(self, left: list[Term], right: list[Term]) -> list[Term]:
        """The terms that meet a term of either side, without contradictory ones."""
        even = self._literal_bits // 3  # ...010101, the propositions without their negations
        met = {a | b for a in left for b in right}
        possible = {term for term in met if not term & term >> 1 & even}
        self._check(len(possible), "transitions of one state")
        return minimal(possible)

    def _obligations(self, formula: Formula) -> Term:
        """The bits of a formula as an obligation, one for each conjunct."""
        if formula.operator is Operator.AND:
            return reduce(or_, map(self._obligations, formula.operands))
        if formula is TRUE:
            return 0
        if formula not in self._next_of:
            self._next_of[formula] = self._new_bit()
            self._obligation_of[self._next_of[formula]] = formula
        return self._next_of[formula]

    def _postponed(self, formula: Formula) -> Term:
        if formula not in self._postponed_of:
            self._postponed_of[formula] = self._new_bit()
        return self._postponed_of[formula]

    def _new_bit(self) -> Term:
        return 1 << len(self._literals) + len(self._next_of) + len(self._postponed_of)

    def _left_for_later(self, term: Term) -> Term:
        return term & ~(self._literal_bits | sum(self._postponed_of.values()))

    def _check(self, size: int, what: str) -> None:
        if size > self._limit:
            raise TranslationLimit(
                f"the automaton of {self._name[:200]} has more than {self._limit} {what}; "
                "split the task into conjuncts: each of them gets its own automaton"
            )
