"""Simplification: an equivalent formula that makes a smaller automaton.

Works on negation normal form, where every law has a dual: exchange & with |, U with R, true
with false. So each law is written once, for a `_Side` that stands for U or for R; the comments
show the case of U. A formula is *eventual* if it holds as soon as it holds at a later position
(F a), *universal* if it then also holds at every later position (G a). One that is both (G F a)
does not depend on any finite prefix of the word. X, U and R add nothing to such formulas.

Source: Etessami and Holzmann, Optimizing Büchi automata, CONCUR 2000; Somenzi and Bloem,
Efficient Büchi automata from LTL formulae, CAV 2000.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Hashable, Iterable
from dataclasses import dataclass, field

from companion.ltl.budget import Budget
from companion.ltl.formula import FALSE, TRUE, Formula, Operator, negate, next_

_STEPS, _STEPS_AN_OPERAND = 100, 25  # of a budget, for one law

_NEUTRAL = {Operator.AND: TRUE, Operator.OR: FALSE}


@dataclass(frozen=True, slots=True, eq=False)
class _Side:
    """U with its laws, whose F is `true U`, or its dual: R, whose G is `false R`.

    Attributes:
        fixpoint: U.
        join: |, over which the right operand of U distributes.
        meet: &, over which the left operand of U distributes.
        top: true, the left operand that makes U an F.
        bottom: false.
        pure: eventual formulas, those with F f = f; grows with the formulas that are seen.
    """

    fixpoint: Operator
    join: Operator
    meet: Operator
    top: Formula
    bottom: Formula
    pure: set[Formula] = field(default_factory=set)

    def make(self, left: Formula, right: Formula) -> Formula:
        """`left U right`."""
        return Formula(self.fixpoint, (left, right))

    def far(self, formula: Formula) -> Formula:
        """`F formula`."""
        return self.make(self.top, formula)

    def is_far(self, formula: Formula) -> bool:
        """Whether a formula is an F."""
        return formula.operator is self.fixpoint and formula.operands[0] is self.top

    def classify(self, node: Formula) -> None:
        """Add a node to the pure ones if it is; its operands are classified."""
        operands = node.operands
        match node.operator:
            case Operator.ATOM | Operator.NOT:
                return
            case Operator.UNTIL | Operator.RELEASE:
                is_pure = operands[1] in self.pure or self.is_far(node)
            case _:
                is_pure = all(operand in self.pure for operand in operands)
        if is_pure:
            self.pure.add(node)


def simplified(formula: Formula, budget: Budget | None = None) -> Formula:
    """An equivalent formula in negation normal form, given one in negation normal form.

    Raises:
        TranslationLimit: the budget is spent; without one there is no limit.

    >>> from companion.ltl.formula import negation_normal_form
    >>> from companion.ltl.parser import parse
    >>> str(simplified(negation_normal_form(parse("F F a | a U (b & false) | F b"))))
    'true U (a | b)'
    """
    until = _Side(Operator.UNTIL, Operator.OR, Operator.AND, TRUE, FALSE)
    release = _Side(Operator.RELEASE, Operator.AND, Operator.OR, FALSE, TRUE)
    final: dict[Formula, Formula] = {}
    pending = [formula]
    while pending:
        node = pending[-1]
        missing = [operand for operand in node.operands if operand not in final]
        if node in final:
            pending.pop()
            continue
        if missing:
            pending += missing
            continue
        rebuilt = Formula(node.operator, tuple(final[f] for f in node.operands), node.atom)
        if budget is not None:
            budget.spend(_STEPS + _STEPS_AN_OPERAND * len(node.operands))
        result = _rewritten(rebuilt, until, release) if rebuilt is node else rebuilt
        if result is node:
            final[node] = node
            until.classify(node)
            release.classify(node)
        elif result in final:
            final[node] = final[result]
        else:
            pending.append(result)
    return final[formula]


def _rewritten(node: Formula, until: _Side, release: _Side) -> Formula:
    """A simpler formula by one law, or the node itself; its operands are simplified."""
    match node.operator:
        case Operator.UNTIL:
            return _fixpoint(node, until, release)
        case Operator.RELEASE:
            return _fixpoint(node, release, until)
        case Operator.OR:
            return _chain(node, until, release)
        case Operator.AND:
            return _chain(node, release, until)
        case Operator.NEXT if node.operands[0] in until.pure and node.operands[0] in release.pure:
            return node.operands[0]  # X G F a = G F a
    return node


def _fixpoint(node: Formula, side: _Side, other: _Side) -> Formula:
    """Laws of `left U right`."""
    left, right = node.operands
    if right in side.pure or left is side.bottom or left is right:
        return right  # a U F b = F b, false U b = b, b U b = b
    if right.operator is side.fixpoint and left in (side.top, right.operands[0]):
        return side.make(left, right.operands[1])  # F(a U b) = F b, a U (a U b) = a U b
    if right.operator is Operator.NEXT and (left is side.top or left.operator is Operator.NEXT):
        before = left if left is side.top else left.operands[0]
        return next_(side.make(before, right.operands[0]))  # X a U X b = X(a U b)
    if side.is_far(node):
        result = _far(node, side, other)
        if result is not node:
            return result
    if right.operator is side.join:  # a U (b | F c) = a U b | F c
        stays = other.pure if _is_waiting(node, side) else ()
        outside = [f for f in right.operands if f in side.pure and f not in stays]
        return _split(node, outside, side, side.join)
    if right.operator is side.meet:  # a U (b & G F c) = a U b & G F c
        outside = [f for f in right.operands if f in side.pure and f in other.pure]
        return _split(node, outside, side, side.meet)
    return node


def _split(node: Formula, outside: list[Formula], side: _Side, operator: Operator) -> Formula:
    """Takes operands that do not need it out of the reach of U."""
    if not outside:
        return node
    left, right = node.operands
    inside = [f for f in right.operands if f not in outside]
    return _joined(operator, [side.make(left, _joined(operator, inside)), *outside])


def _far(node: Formula, side: _Side, other: _Side) -> Formula:
    """Laws of `F right`."""
    right = node.operands[1]
    alternatives = right.operands if right.operator is side.join else (right,)
    parts = [part for f in alternatives for part in _parted(f, side, other)]
    if len(parts) > len(alternatives) or any(f not in alternatives for f in parts):
        return side.far(_joined(side.join, parts))
    return _once_for_all(node, side, other) if side.fixpoint is Operator.RELEASE else node


def _parted(alternative: Formula, side: _Side, other: _Side) -> list[Formula]:
    """The alternatives that one under F is worth: X G a is G a, and G(b | G a) is G b | G a."""
    body = alternative.operands[-1] if alternative.operands else alternative
    if alternative.operator is Operator.NEXT and body in other.pure:
        return [body]
    if other.is_far(alternative) and body.operator is side.join:
        universal = [f for f in body.operands if f in other.pure]
        rest = _joined(side.join, [f for f in body.operands if f not in other.pure])
        return [other.far(rest), *universal] if universal else [alternative]
    return [alternative]


def _once_for_all(node: Formula, always: _Side, eventually: _Side) -> Formula:
    """G(t | F p & F q) = G(F p & F q) | G t | F(F p & F q & X G t).

    What is eventual either holds for ever or fails for ever from some position on. So the
    automaton need not keep track of what is owed as long as it may still have to be paid again.
    It has fewer states from two operands on.
    """
    body = node.operands[1]
    owed: dict[Formula, list[Formula]] = defaultdict(list)  # by the formula that pays
    kept = []
    for clause in body.operands if body.operator is Operator.AND else (body,):
        ways = clause.operands if clause.operator is Operator.OR else (clause,)
        eventual = [f for f in ways if f in eventually.pure]
        if len(eventual) == 1 < len(ways):
            (goal,) = eventual
            way_out = _joined(Operator.OR, [f for f in ways if f is not goal])
            owed[way_out] += goal.operands if goal.operator is Operator.AND else eventual
        else:
            kept.append(clause)
    parts = []
    for way_out, goals in owed.items():
        if len(goals) == 1:
            kept.append(_joined(Operator.OR, [way_out, *goals]))
            continue
        once = _joined(Operator.AND, [*goals, next_(always.far(way_out))])
        recurring = always.far(_joined(Operator.AND, goals))
        parts.append(_joined(Operator.OR, [recurring, always.far(way_out), eventually.far(once)]))
    if kept:
        parts.append(always.far(_joined(Operator.AND, kept)))
    return _joined(Operator.AND, parts) if owed and len(parts) > bool(kept) else node


def _chain(node: Formula, side: _Side, other: _Side) -> Formula:
    """Laws of a chain of |, the join of `side` and the meet of `other`."""
    operator = node.operator
    parts: dict[Formula, None] = {}
    for operand in node.operands:
        parts.update(dict.fromkeys(operand.operands if operand.operator is operator else [operand]))
    parts.pop(side.bottom, None)
    if side.top in parts or any(f.operator is Operator.NOT and negate(f) in parts for f in parts):
        return side.top
    eventual = {f.operands[1] for f in parts if f.operator is side.fixpoint}
    kept = []
    for part in parts:
        is_absorbed = (
            part in eventual  # b | a U b = a U b
            or (part.operator is side.meet and any(f in parts for f in part.operands))  # a | a & b
            or (part.operator is other.fixpoint and part.operands[1] in parts)  # b | a R b = b
        )
        if not is_absorbed:
            kept.append(part)
    kept = _grouped(_weakened(kept, side, other), side, other)
    return _joined(operator, _gathered(kept, side, other))


def _gathered(parts: list[Formula], side: _Side, other: _Side) -> list[Formula]:
    """F a | G F b = F(a | G F b): a run waits for both in one state."""
    waiting = next((f for f in parts if _is_waiting(f, side)), None)
    ageless = [f for f in parts if f in side.pure and f in other.pure and f is not waiting]
    if waiting is None or not ageless:
        return parts
    whole = side.far(_joined(side.join, [waiting.operands[1], *ageless]))
    return [whole, *(f for f in parts if f is not waiting and f not in ageless)]


def _is_waiting(formula: Formula, side: _Side) -> bool:
    """Whether a formula is an F on the side of U; what is done with these has no useful dual."""
    return side.fixpoint is Operator.UNTIL and side.is_far(formula)


def _weakened(parts: list[Formula], side: _Side, other: _Side) -> list[Formula]:
    """G a | a U b = b R (a | b), and G a | F(!a & F b) = (!a & F b) R (a | !a & F b)."""
    found = {f.operands[1]: f for f in parts if other.is_far(f)}
    for part in parts:
        if part.operator is not side.fixpoint:
            continue
        before, event = part.operands
        if before is side.top and event.operator is side.meet:
            rest = [f for f in event.operands if f not in side.pure]
            if len(rest) == 1 and rest[0].operator in (Operator.ATOM, Operator.NOT):
                before = negate(rest[0])
        if before in found:
            weak = other.make(event, _joined(side.join, [before, event]))
            return [weak if f is part else f for f in parts if f is not found[before]]
    return parts


def _grouped(parts: Iterable[Formula], side: _Side, other: _Side) -> list[Formula]:
    """Operands of a chain of |, those that can be said together as one."""
    groups: dict[Hashable, list[Formula]] = defaultdict(list)
    for part in parts:
        if other.is_far(part) and side.is_far(part.operands[1]):
            groups["far"].append(part)
        elif part.operator is Operator.NEXT:
            groups[Operator.NEXT].append(part)
        elif part.operator is side.fixpoint:
            groups[side.fixpoint, part.operands[0]].append(part)
        elif part.operator is other.fixpoint:
            groups[other.fixpoint, part.operands[1]].append(part)
        else:
            groups[part].append(part)
    return [_together(group, side, other) if group[1:] else group[0] for group in groups.values()]


def _together(group: list[Formula], side: _Side, other: _Side) -> Formula:
    """One formula for the disjunction of a group."""
    first = group[0]
    if first.operator is Operator.NEXT:  # X a | X b = X(a | b)
        return next_(_joined(side.join, [f.operands[0] for f in group]))
    if other.is_far(first) and side.is_far(first.operands[1]):  # G F a | G F b = G F(a | b)
        bodies = [f.operands[1].operands[1] for f in group]
        return other.far(side.far(_joined(side.join, bodies)))
    if first.operator is side.fixpoint:  # a U b | a U c = a U (b | c)
        return side.make(first.operands[0], _joined(side.join, [f.operands[1] for f in group]))
    # a R c | b R c = (a | b) R c
    return other.make(_joined(side.join, [f.operands[0] for f in group]), first.operands[1])


def _joined(operator: Operator, parts: list[Formula]) -> Formula:
    if len(parts) > 1:
        return Formula(operator, tuple(parts))
    return parts[0] if parts else _NEUTRAL[operator]
