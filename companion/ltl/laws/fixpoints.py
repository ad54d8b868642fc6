"""Laws of U, and of R.

Source: Etessami and Holzmann, Optimizing Büchi automata, CONCUR 2000; Somenzi and Bloem,
Efficient Büchi automata from LTL formulae, CAV 2000; Babiak, Křetínský, Řehák and Strejček, LTL to
Büchi automata translation: fast and more deterministic, TACAS 2012, for eventual formulas.
"""

from __future__ import annotations

from collections import defaultdict

from companion.ltl.formula import Formula, Operator, next_
from companion.ltl.laws.facts import without_facts
from companion.ltl.laws.implication import MAX_OPERANDS, Implication
from companion.ltl.laws.sides import Side, is_waiting, joined


def fixpoint(node: Formula, side: Side, other: Side, implication: Implication) -> Formula:
    """The formula that one law of `left U right` makes simpler, or the node itself."""
    left, right = node.operands
    if right in side.pure or left is side.bottom or left is right:
        return right  # a U F b = F b, false U b = b, b U b = b
    if right.operator is side.fixpoint and left in (side.top, right.operands[0]):
        return side.make(left, right.operands[1])  # F(a U b) = F b, a U (a U b) = a U b
    if right.operator is Operator.NEXT:
        if left.operator is Operator.NEXT:
            return next_(side.make(left.operands[0], right.operands[0]))  # X a U X b = X(a U b)
        if left is side.top or (left in side.pure and left in other.pure):
            return next_(side.make(left, right.operands[0]))  # G F a U X b = X(G F a U b)
    if side.is_far(node):
        result = _far(node, side, other, implication)
    else:
        result = _with_left(node, side, other, implication)
    if result is not node:
        return result
    if right.operator is side.join:  # a U (b | F c) = a U b | F c
        stays = other.pure if is_waiting(node, side) else ()
        outside = [f for f in right.operands if f in side.pure and f not in stays]
        return _split(node, outside, side, side.join)
    if right.operator is side.meet:  # a U (b & G F c) = a U b & G F c
        outside = [f for f in right.operands if f in side.pure and f in other.pure]
        return _split(node, outside, side, side.meet)
    return node


def _with_left(node: Formula, side: Side, other: Side, implication: Implication) -> Formula:
    """Laws of `left U right` whose operands imply each other; left is not true."""
    left, right = node.operands

    def below(one: Formula, other: Formula) -> bool:
        return implication.is_below(one, other, side)

    if below(left, right):
        return right
    if left.operator is Operator.NEXT and below(left.operands[0], implication.opposite(right)):
        return right  # X !b U b = b
    if right.operator is side.meet and left in right.operands:
        if all(f in side.pure for f in right.operands if f is not left):
            return right  # a U (a & F b) = a & F b
    if below(implication.opposite(left), right) or (left in side.pure and below(right, left)):
        return side.far(right)  # !b U b = F b, F b U b = F b
    if right.operator is side.fixpoint:
        if below(left, right.operands[0]):
            return right  # (a & b) U (a U c) = a U c
        if below(right.operands[0], left):
            return side.make(left, right.operands[1])  # a U ((a & b) U c) = a U c
    if left.operator is side.fixpoint and below(left.operands[1], right):
        return joined(side.join, [left, right])  # (a U b) U b = a U b | b
    if right.operator is side.join and other.far(left) in right.operands:
        event = joined(side.join, [f for f in right.operands if f is not other.far(left)])
        return other.make(event, joined(side.join, [left, event]))  # a U (b | G a) = b R (a | b)
    if left in side.pure and left in other.pure:
        if below(right, left):
            return joined(side.meet, [left, side.far(right)])  # (G F a) U b, b implying G F a
        if right in other.pure and side.fixpoint is Operator.UNTIL:
            recurring = joined(side.meet, [left, side.far(right)])
            return joined(side.join, [right, recurring])  # (G F a) U G b = G b | G F a & F G b
    return _with_shorter_left(node, side, implication)


def _with_shorter_left(node: Formula, side: Side, implication: Implication) -> Formula:
    """(a | b) U b = a U b, and (a & !b) U b = a U b."""
    left, right = node.operands
    if left.operator not in (side.join, side.meet) or len(left.operands) > MAX_OPERANDS:
        return node
    kept = [
        operand
        for operand in left.operands
        if not implication.is_below(
            operand if left.operator is side.join else implication.opposite(operand), right, side
        )
    ]
    return side.make(joined(left.operator, kept), right) if len(kept) < len(left.operands) else node


def _split(node: Formula, outside: list[Formula], side: Side, operator: Operator) -> Formula:
    """Moves operands out of U that do not need it."""
    if not outside:
        return node
    left, right = node.operands
    inside = [f for f in right.operands if f not in outside]
    return joined(operator, [side.make(left, joined(operator, inside)), *outside])


def _far(node: Formula, side: Side, other: Side, implication: Implication) -> Formula:
    """Laws of `F right`."""
    right = node.operands[1]
    if side.fixpoint is Operator.RELEASE and right.operator is Operator.UNTIL:
        before, event = right.operands
        if not other.is_far(right):  # G(a U b) = G((a | b) & F b)
            waiting = joined(side.meet, [before, event])
            return side.far(joined(side.join, [waiting, other.far(event)]))
    for far in right.operands if right.operator is side.meet else ():
        if side.is_far(far):  # F(a & F b) = F b if b implies a
            rest = joined(side.meet, [f for f in right.operands if f is not far])
            if implication.is_below(far.operands[1], rest, side):
                return far
    alternatives = right.operands if right.operator is side.join else (right,)
    parts = [part for f in alternatives for part in _parted(f, side, other)]
    if len(parts) > len(alternatives) or any(f not in alternatives for f in parts):
        return side.far(joined(side.join, parts))
    if len(parts) > 1:
        shorter = without_facts(parts, [[part] for part in parts], side, other)
        if shorter != parts:
            return side.far(joined(side.join, shorter))
    return _once_for_all(node, side, other) if side.fixpoint is Operator.RELEASE else node


def _parted(alternative: Formula, side: Side, other: Side) -> list[Formula]:
    """The alternatives that may replace an alternative under F.

    X G a is G a, G(b | G a) is G b | G a, G(b | F a) is G b | G F a. Under G, F(a R b) may be
    replaced by F(a & b | G b).
    """
    body = alternative.operands[-1] if alternative.operands else alternative
    if alternative.operator is Operator.NEXT and body in other.pure:
        return [body]
    if alternative in other.pure and (now := _now(alternative, side, other)) is not alternative:
        return [now]
    if not other.is_far(alternative):
        return [alternative]
    choices = body.operands if body.operator is side.join else (body,)
    pure = [f for f in choices if f in other.pure or f in side.pure]
    rest = [f for f in choices if f not in pure]
    if len(choices) > 1 and pure:
        return [other.far(f) for f in ([joined(side.join, rest)] if rest else []) + pure]
    if body.operator is side.fixpoint and not side.is_far(body):
        before, event = body.operands
        waiting = joined(side.join, [before, event])
        return [other.far(joined(side.meet, [waiting, side.far(event)]))]
    return [alternative]


def _now(alternative: Formula, side: Side, other: Side) -> Formula:
    """A universal formula under F without X: X G a & G(b & X c) counts as G a & G(b & c)."""
    parts = []
    for part in alternative.operands if alternative.operator is side.meet else (alternative,):
        bare = part.operands[0] if part.operator is Operator.NEXT else part
        if other.is_far(bare):
            body = bare.operands[1]
            inner = body.operands if body.operator is side.meet else (body,)
            bare = other.far(joined(side.meet, [_bare(f, side, other) for f in inner]))
        parts.append(bare)
    return joined(side.meet, parts)


def _bare(part: Formula, side: Side, other: Side) -> Formula:
    """A part under F G: a instead of X a, and instead of F G a."""
    if part.operator is Operator.NEXT:
        return part.operands[0]
    if side.is_far(part) and other.is_far(part.operands[1]):
        return part.operands[1].operands[1]
    return part


def _once_for_all(node: Formula, always: Side, eventually: Side) -> Formula:
    """G(t | F p & F q) = G(F p & F q) | G t | F(F p & F q & X G t).

    An eventual formula either always holds again, or fails for ever from some position on. So the
    automaton need not track a debt while it may have to be paid again. With two or more operands it
    has fewer states.
    """
    body = node.operands[1]
    owed: dict[Formula, list[Formula]] = defaultdict(list)  # debts, by the formula that pays them
    kept = []
    for clause in body.operands if body.operator is Operator.AND else (body,):
        ways = clause.operands if clause.operator is Operator.OR else (clause,)
        eventual = [f for f in ways if f in eventually.pure]
        if len(eventual) == 1 < len(ways):
            (goal,) = eventual
            way_out = joined(Operator.OR, [f for f in ways if f is not goal])
            owed[way_out] += goal.operands if goal.operator is Operator.AND else eventual
        else:
            kept.append(clause)
    parts = []
    for way_out, goals in owed.items():
        if len(goals) == 1:
            kept.append(joined(Operator.OR, [way_out, *goals]))
            continue
        once = joined(Operator.AND, [*goals, next_(always.far(way_out))])
        recurring = always.far(joined(Operator.AND, goals))
        parts.append(joined(Operator.OR, [recurring, always.far(way_out), eventually.far(once)]))
    if kept:
        parts.append(always.far(joined(Operator.AND, kept)))
    return joined(Operator.AND, parts) if owed and len(parts) > bool(kept) else node
