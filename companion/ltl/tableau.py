"""The tableau: from a formula in negation normal form to a first, rough automaton.

A state is a set of obligations: formulas that must hold from the next position on. Expanding an
obligation splits it into what must hold now and what is left for later. An until can be fulfilled
now or postponed, but a run that postpones the same until for ever must not be accepted. So each
until has its mark, on all transitions that do not postpone it.

A *term* is one way to meet a set of obligations, as a set of bits in an int: literals that must
hold now (two bits a proposition), obligations for the next position, postponed untils. If a term is
a subset of another, it demands less, and the other is redundant. With sets of letters as labels, a
term can lose those of its letters for which another term demands less from then on.

A disjunction of one U or R with eventual formulas waits as a whole: a U b | F c is b | F c | a &
X(a U b | F c), because F c may also begin later.

Source: Couvreur, On-the-fly verification of linear temporal logic, FM 1999; Giannakopoulou and
Lerda, From states to transitions, FORTE 2002; Gastin and Oddoux, Fast LTL to Büchi automata
translation, CAV 2001, for merging states and dropping transitions on the fly.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial, reduce
from operator import or_

from companion.ltl.bitsets import indices, minimal
from companion.ltl.budget import Budget, TranslationLimit
from companion.ltl.formula import FALSE, TRUE, Formula, Operator, disjoin, release, subformulas
from companion.ltl.graph import LabelledEdge, LabelledGraph
from companion.ltl.labels import Alphabet, Cube, L, LetterSet
from companion.ltl.laws.sides import both_sides

Term = int
"""A set of bits: literals, obligations, postponed untils. No bits means no demand."""

_FIXPOINTS = (Operator.UNTIL, Operator.RELEASE)


def unfolded(
    formula: Formula, alphabet: Alphabet, max_states: int, budget: Budget
) -> LabelledGraph[Cube]:
    """The automaton of a formula in negation normal form.

    Args:
        alphabet: the alphabet, which contains at least the formula's propositions.

    Raises:
        TranslationLimit: there would be more than `max_states` states, or that many transitions of
            one state, or the budget is spent.
    """
    tableau = _Tableau(alphabet.names, alphabet.exclusive, max_states, budget)
    return tableau.graph(formula, tableau.with_cubes)


def unfolded_by_letters(
    formula: Formula, alphabet: Alphabet, max_states: int, budget: Budget
) -> LabelledGraph[LetterSet]:
    """The automaton with sets of letters: more deterministic, often with other states.

    Raises:
        TranslationLimit: as `unfolded`.
    """
    tableau = _Tableau(alphabet.names, alphabet.exclusive, max_states, budget)
    return tableau.graph(formula, partial(tableau.with_letters, alphabet))


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
        self._not_later = self._literal_bits  # the bits that demand nothing of the next position
        self._until, _ = both_sides()  # knows which formulas are eventual
        self._terms_of: dict[Formula, list[Term]] = {}
        self._terms_of_group: dict[Term, list[Term]] = {}

    def with_cubes(self, terms: Sequence[Term]) -> list[tuple[Cube, Term]]:
        """Terms, each with a cube of the letters that it allows."""
        return [(Cube(term & self._literal_bits), term) for term in terms]

    def with_letters(
        self, alphabet: Alphabet, terms: Sequence[Term]
    ) -> list[tuple[LetterSet, Term]]:
        """Terms, each with the letters for which no other term demands less from then on."""
        self._budget.spend(len(terms) ** 2, alphabet.every.bit_length())
        read = [alphabet.letters(cube) for cube, _ in self.with_cubes(terms)]
        later = [term & ~self._literal_bits for term in terms]
        found = []
        for i, term in enumerate(terms):
            letters = read[i]
            for j, other in enumerate(later):
                if i != j and later[i] & other == other and (later[i] != other or j < i):
                    letters &= ~read[j]
            if letters:
                found.append((letters, term))
        return found

    def graph(
        self, formula: Formula, labelled: Callable[[Sequence[Term]], list[tuple[L, Term]]]
    ) -> LabelledGraph[L]:
        """The automaton; sets of obligations with equal terms are one state.

        Args:
            labelled: finds the labels of a state's terms; a term without a label is left out.
        """
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

        for node in subformulas(formula):
            self._until.classify(node)
        state(self._obligations(formula))
        edges = []
        for terms in pending:  # grows while it is read
            ways = labelled(terms)
            edges.append([(label, t, state(t & ~self._not_later)) for label, t in ways])
        marks = {bit: 1 << i for i, bit in enumerate(self._postponed_of.values())}
        self._budget.spend(sum(map(len, edges)) * (1 + len(marks)), self._width)
        return LabelledGraph(
            [
                [
                    LabelledEdge(
                        label,
                        sum(mark for bit, mark in marks.items() if not term & bit),
                        target,
                    )
                    for label, term, target in leaving
                ]
                for leaving in edges
            ],
            len(marks),
        )

    def _expand_all(self, obligations: Term) -> list[Term]:
        """The terms of a set of obligations.

        Obligations without common bits are expanded separately, because their terms need not be
        compared. The few sets of obligations with common bits occur in many states.
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
        """The terms of a formula, found after those of its operands."""
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
        """The terms of a formula, given those of its operands: the expansion laws of LTL."""
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
                terms = {operand: self._terms_of[operand] for operand in operands}
                if waiting := self._waiting(operands):
                    terms[waiting] = self._delayed(terms[waiting], waiting, node)
                return self._union(*terms.values())
            case Operator.UNTIL, (before, event):
                postpone = self._obligations(node) | self._postponed(node)
                later = self._product(self._terms_of[before], [postpone])
                events = event.operands if event.operator is Operator.OR else (event,)
                return self._union(*(self._terms_of[f] for f in events), later)  # U waits itself
            case Operator.RELEASE, (event, kept):
                ways = self._union(self._terms_of[event], [self._obligations(node)])
                return self._product(self._terms_of[kept], ways)
        return [self._bit_of[node]]

    def _waiting(self, alternatives: Sequence[Formula]) -> Formula | None:
        """The operand that is a U or an R; None if more than this operand is not eventual.

        Also None if another operand leads to it, because then it is a state anyway.
        """
        rest = [f for f in alternatives if f not in self._until.pure]
        choices = [f for f in rest or alternatives if f.operator in _FIXPOINTS]
        if len(rest) > 1 or not choices:
            return None
        others = [f for f in alternatives if f is not choices[0]]
        return None if choices[0] in subformulas(disjoin(*others)) else choices[0]

    def _delayed(self, terms: Sequence[Term], part: Formula, whole: Formula) -> list[Term]:
        """The terms of a part of a disjunction; those that wait for the part wait for the whole."""
        one, every = self._obligations(part), self._obligations(whole)
        return [term & ~one | every if term & ~self._not_later == one else term for term in terms]

    def _union(self, *choices: list[Term]) -> list[Term]:
        """The terms that meet at least one of the choices."""
        return self._minimal({term for terms in choices for term in terms})

    def _product(self, left: list[Term], right: list[Term]) -> list[Term]:
        """The terms that meet a term of either side; contradictory ones are left out."""
        if left == [0] or right == [0]:
            return right if left == [0] else left
        self._budget.spend(len(left) * len(right), self._width)
        possible = {term for a in left for b in right if not self._is_contradictory(term := a | b)}
        self._check(len(possible), "transitions of one state")
        if reduce(or_, left, 0) & reduce(or_, right, 0):
            return self._minimal(possible)
        return list(possible)  # minimal, as both sides are and they share no bit

    def _is_contradictory(self, term: Term) -> bool:
        even = self._literal_bits // 3  # ...010101, the propositions without their negations
        places = term & self._exclusive
        return bool(term & term >> 1 & even or places & (places - 1))

    def _minimal(self, terms: set[Term]) -> list[Term]:
        return minimal(terms, partial(self._budget.spend, width=self._width))

    def _obligations(self, formula: Formula) -> Term:
        """The bits of a formula as obligations, one for each conjunct."""
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
        """Number of bits of a term."""
        return len(self._bit_of) + len(self._next_of) + len(self._postponed_of)

    def _new_bit(self) -> Term:
        return 1 << self._width

    def _check(self, size: int, what: str) -> None:
        if size > self._limit:
            raise TranslationLimit(f"{self._limit:,} {what}")
