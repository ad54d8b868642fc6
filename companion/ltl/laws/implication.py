"""Implication: which formulas imply which, as far as their shape shows.

Deciding implication is as hard as satisfiability. Comparing operators and operands is cheap and
answers the questions that occur: a "no" may be wrong, a "yes" never is.

Source: Somenzi and Bloem, Efficient Büchi automata from LTL formulae, CAV 2000; Duret-Lutz, LTL
translation improvements in Spot 1.0, IJCCBS 2014, for eventual and universal formulas.
"""

from __future__ import annotations

from dataclasses import dataclass, field

from companion.ltl.budget import Budget
from companion.ltl.formula import FALSE, TRUE, Formula, Operator, dual
from companion.ltl.laws.sides import Side

MAX_OPERANDS = 16
"""The most operands of a chain that are compared with each other."""

_MAX_DEPTH = 10
_STEPS = 30  # of a budget, for one comparison

_LITERALS = (Operator.ATOM, Operator.NOT)


@dataclass(frozen=True, slots=True, eq=False)
class Implication:
    """What is known of the formulas seen so far, and of their negations."""

    until: Side
    release: Side
    budget: Budget
    _opposite: dict[Formula, Formula] = field(default_factory=dict)
    _known: dict[tuple[Formula, Formula], bool] = field(default_factory=dict)

    def learn(self, node: Formula) -> None:
        """Makes a formula known; its operands are known already."""
        if node in self._opposite:
            return
        opposite = dual(node, [self._opposite[operand] for operand in node.operands])
        self._opposite.update({node: opposite, opposite: node})
        for side, other in ((self.until, self.release), (self.release, self.until)):
            side.classify(node)
            if node in side.pure:
                other.pure.add(opposite)

    def opposite(self, node: Formula) -> Formula:
        """The negation of a known formula, in negation normal form."""
        return self._opposite[node]

    def is_below(self, one: Formula, other: Formula, side: Side) -> bool:
        """Whether a chain of | can drop the first formula beside the second."""
        return self.holds(one, other) if side is self.until else self.holds(other, one)

    def holds(self, one: Formula, other: Formula, depth: int = 0) -> bool:
        """Whether the first formula is found to imply the second."""
        if one is other or one is FALSE or other is TRUE:
            return True
        if (one.operator in _LITERALS and other.operator in _LITERALS) or depth > _MAX_DEPTH:
            return False
        if (one, other) not in self._known:
            self.budget.spend(_STEPS)
            self._known[one, other] = self._follows(one, other, depth + 1)
        return self._known[one, other]

    def _follows(self, one: Formula, other: Formula, depth: int) -> bool:
        kinds = one.operator, other.operator
        if max(len(one.operands), len(other.operands)) > MAX_OPERANDS:
            return False
        if kinds[1] is Operator.AND:
            return all(self.holds(one, operand, depth) for operand in other.operands)
        if kinds[0] is Operator.OR:
            return all(self.holds(operand, other, depth) for operand in one.operands)
        return (
            (kinds[0] is Operator.AND and any(self.holds(f, other, depth) for f in one.operands))
            or (kinds[1] is Operator.OR and any(self.holds(one, f, depth) for f in other.operands))
            or (kinds[0] is kinds[1] and self._operands_follow(one, other, depth))
            or self._weakens(one, other, depth)
            or self._strengthens(one, other, depth)
        )

    def _operands_follow(self, one: Formula, other: Formula, depth: int) -> bool:
        """Compares operands: X, U and R are monotonic in theirs."""
        if one.operator not in (Operator.NEXT, Operator.UNTIL, Operator.RELEASE):
            return False
        pairs = zip(one.operands, other.operands, strict=True)
        return all(self.holds(a, b, depth) for a, b in pairs)

    def _weakens(self, one: Formula, other: Formula, depth: int) -> bool:
        """Whether what X, U or R says about now implies the other formula."""
        match one.operator, one.operands:
            case Operator.NEXT, (later,):
                return other in self.until.pure and self.holds(later, other, depth)
            case Operator.RELEASE, (_, kept):
                return self.holds(kept, other, depth)
            case Operator.UNTIL, (before, event) if self.holds(event, other, depth):
                # once the event has come, c R d holds; before that d has to hold
                asked = other.operands[1] if other.operator is Operator.RELEASE else other
                return other in self.until.pure or self.holds(before, asked, depth)
        return False

    def _strengthens(self, one: Formula, other: Formula, depth: int) -> bool:
        """Whether the first formula implies what X, U or R needs now."""
        match other.operator, other.operands:
            case Operator.NEXT, (later,):
                return one in self.release.pure and self.holds(one, later, depth)
            case Operator.UNTIL, (_, event):
                return self.holds(one, event, depth)
            case Operator.RELEASE, (event, kept) if self.holds(one, kept, depth):
                # a U b holds until b comes, which releases
                given = one.operands[1] if one.operator is Operator.UNTIL else one
                return one in self.release.pure or self.holds(given, event, depth)
        return False
