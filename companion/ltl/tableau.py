"""The tableau: from a formula in negation normal form to a first, rough automaton.

A state is a set of obligations: formulas that must hold from the next position on. Expanding an
obligation splits it into what must hold now and what is left for later; an until can be
fulfilled now or postponed, and a run that postpones the same until for ever is wrong. So each
until has its mark, on all transitions that do not postpone it.

A *term* is one way to meet a set of obligations, written as a set of bits in an int: literals
that must hold now (two bits a proposition), obligations for the next position, untils postponed.
A term that is a subset of another asks for less, so the other is superfluous.

Source: Couvreur, On-the-fly verification of linear temporal logic, FM 1999; Giannakopoulou and
Lerda, From states to transitions, FORTE 2002; Gastin and Oddoux, Fast LTL to Büchi automata
translation, CAV 2001, for merging states and dropping transitions on the fly.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial, reduce
from operator import or_

from companion.ltl.bitsets import indices, minimal
from companion.ltl.budget import Budget, TranslationLimit
from companion.ltl.formula import FALSE, TRUE, Formula, Operator, release
from companion.ltl.graph import LabelledEdge, LabelledGraph
from companion.ltl.labels import Alphabet, Cube

Term = int
"""A set of bits: literals, obligations, postponed untils. No bits: nothing is asked."""


def unfolded(
    formula: Formula, alphabet: Alphabet, max_states: int, budget: Budget
) -> LabelledGraph[Cube]:
    """The automaton of a formula in negation normal form.

    Args:
        alphabet: over propositions, at least those of the formula.

    Raises:
        TranslationLimit: there would be more than `max_states` states, or as many transitions of
            one state, or the budget is spent.
    """
    return _Tableau(alphabet.names, alphabet.exclusive, max_states, budget).graph(formula)


class _Tableau:
    """Expands sets of obligations."""

    def __init__(
        self, names: Sequence[str], exclusive: frozenset[str], limit: int, budget: Budget
    ) -> None:
        self._limit = limit
        self._budget = budget
        self._bit_of: dict[Formula, Term] = {}  # of literals, the lowest bits: p, !p, q, !q, ...
        for i, name in enumerate(names):
            proposition = Formula(Operator.ATOM, (), name)
            self._bit_of[proposition] = 1 << 2 * i
            self._bit_of[Formula(Operator.NOT, (proposition,))] = 2 << 2 * i
        self._literal_bits = (1 << len(self._bit_of)) - 1
        self._exclusive = sum(1 << 2 * i for i, name in enumerate(names) if name in exclusive)
        self._next_of: dict[Formula, Term] = {}
        self._obligation_of: dict[Term, Formula] = {}
        self._postponed_of: dict[Formula, Term] = {}
        self._not_later = self._literal_bits  # what a term does not ask of the next position
        self._terms_of: dict[Formula, list[Term]] = {}
        self._terms_of_group: dict[Term, list[Term]] = {}

    def graph(self, formula: Formula) -> LabelledGraph[Cube]:
        """The automaton; sets of obligations with equal terms are one state."""
        number_of: dict[tuple[Term, ...], int] = {}
        state_of: dict[Term, int] = {}
        pending: list[tuple[Term, ...]] = []

        def state(obligations: Term) -> int:
            if obligations not in state_of:
                terms = tuple(sorted(self._expand_all(obligations)))
                self._budget.keep(len(terms), self._width)
                state_of[obligations] = number_of.setdefault(terms, len(number_of))
                if state_of[obligations] == len(pending):
                    pending.append(terms)
                    self._check(len(pending), "states")
            return state_of[obligations]

        state(self._obligations(formula))
        edges = []
        for terms in pending:  # grows while it is read
            edges.append([(term, state(term & ~self._not_later)) for term in terms])
        marks = {bit: 1 << i for i, bit in enumerate(self._postponed_of.values())}
        self._budget.spend(sum(map(len, edges)) * (1 + len(marks)), self._width)
        return LabelledGraph(
            [
                [
                    LabelledEdge(
                        Cube(term & self._literal_bits),
                        sum(mark for bit, mark in marks.items() if not term & bit),
                        target,
                    )
                    for term, target in leaving
                ]
                for leaving in edges
            ],
            len(marks),
        )

    def _expand_all(self, obligations: Term) -> list[Term]:
        """The terms of a set of obligations.

        Those that have no bit in common are expanded apart: their terms need no comparison, and
        the terms of the few sets of those that do come back in many states.
        """
        groups: list[tuple[Term, Term]] = []  # bits of the terms, obligations
        known = 0
        for index in indices(obligations):
            group = 1 << index
            bits = reduce(or_, self._expand(self._obligation_of[group]), 0)
            if bits & known:
                self._budget.spend(len(groups), self._width)
                touched = [pair for pair in groups if pair[0] & bits]
                groups = [pair for pair in groups if not pair[0] & bits]
                bits, group = (
                    reduce(or_, column) for column in zip((bits, group), *touched, strict=True)
                )
            groups.append((bits, group))
            known |= bits
        return reduce(self._product, (self._expand_group(group) for _, group in groups), [0])

    def _expand_group(self, obligations: Term) -> list[Term]:
        if obligations not in self._terms_of_group:
            each = (self._expand(self._obligation_of[1 << i]) for i in indices(obligations))
            terms = reduce(self._product, each, [0])
            self._budget.keep(len(terms), self._width)
            self._terms_of_group[obligations] = terms
        return self._terms_of_group[obligations]

    def _expand(self, formula: Formula) -> list[Term]:
        """The terms of a formula, those of its operands first."""
        pending = [formula]
        while pending:
            node = pending[-1]
            needed = () if node.operator in (Operator.NEXT, Operator.NOT) else node.operands
            missing = [operand for operand in needed if operand not in self._terms_of]
            if not missing:
                terms = self._terms(node)
                self._budget.keep(len(terms), self._width)
                self._terms_of[pending.pop()] = terms
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
                return self._union(*(self._terms_of[operand] for operand in operands))
            case Operator.UNTIL, (before, event):
                postpone = self._obligations(node) | self._postponed(node)
                later = self._product(self._terms_of[before], [postpone])
                return self._union(self._terms_of[event], later)
            case Operator.RELEASE, (event, kept):
                ways = self._union(self._terms_of[event], [self._obligations(node)])
                return self._product(self._terms_of[kept], ways)
        return [self._bit_of[node]]

    def _union(self, *choices: list[Term]) -> list[Term]:
        """The terms that meet one of the choices."""
        return self._minimal({term for terms in choices for term in terms})

    def _product(self, left: list[Term], right: list[Term]) -> list[Term]:
        """The terms that meet a term of either side, without contradictory ones."""
        if left == [0] or right == [0]:
            return right if left == [0] else left
        self._budget.spend(len(left) * len(right), self._width)
        possible = {term for a in left for b in right if not self._is_contradictory(term := a | b)}
        self._check(len(possible), "transitions of one state")
        if reduce(or_, left, 0) & reduce(or_, right, 0):
            return self._minimal(possible)
        return list(possible)  # as both sides are, if they have nothing in common

    def _is_contradictory(self, term: Term) -> bool:
        even = self._literal_bits // 3  # ...010101, the propositions without their negations
        places = term & self._exclusive
        return bool(term & term >> 1 & even or places & (places - 1))

    def _minimal(self, terms: set[Term]) -> list[Term]:
        return minimal(terms, partial(self._budget.spend, width=self._width))

    def _obligations(self, formula: Formula) -> Term:
        """The bits of a formula as an obligation, one for each conjunct."""
        if formula.operator is Operator.AND:
            return reduce(or_, map(self._obligations, formula.operands))
        if formula is TRUE:
            return 0
        if formula.operator is Operator.RELEASE and formula.operands[0] is FALSE:
            body = formula.operands[1]
            if body.operator is Operator.AND:  # G(a & b) = G a & G b
                return reduce(or_, (self._obligations(release(FALSE, f)) for f in body.operands))
        if formula not in self._next_of:
            self._next_of[formula] = self._new_bit()
            self._obligation_of[self._next_of[formula]] = formula
        return self._next_of[formula]

    def _postponed(self, formula: Formula) -> Term:
        if formula not in self._postponed_of:
            self._postponed_of[formula] = self._new_bit()
            self._not_later |= self._postponed_of[formula]
        return self._postponed_of[formula]

    @property
    def _width(self) -> int:
        """Bits of a term."""
        return len(self._bit_of) + len(self._next_of) + len(self._postponed_of)

    def _new_bit(self) -> Term:
        return 1 << self._width

    def _check(self, size: int, what: str) -> None:
        if size > self._limit:
            raise TranslationLimit(f"{self._limit:,} {what}")
