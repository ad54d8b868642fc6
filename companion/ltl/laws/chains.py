"""Laws of chains of | and of &.

Source: Etessami and Holzmann, Optimizing Büchi automata, CONCUR 2000; Somenzi and Bloem,
Efficient Büchi automata from LTL formulae, CAV 2000.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Collection, Hashable, Iterable, Sequence

from companion.ltl.formula import Formula, Operator, negate, next_
from companion.ltl.laws.facts import without_facts
from companion.ltl.laws.implication import MAX_OPERANDS, Implication
from companion.ltl.laws.sides import Side, is_waiting, joined


def chain(node: Formula, side: Side, other: Side, implication: Implication) -> Formula:
    """The formula that the laws of | make simpler; | is the join of `side`, & the meet."""
    operator = node.operator
    parts: dict[Formula, None] = {}
    for operand in node.operands:
        parts.update(dict.fromkeys(operand.operands if operand.operator is operator else [operand]))
    parts.pop(side.bottom, None)
    if side.top in parts or any(f.operator is Operator.NOT and negate(f) in parts for f in parts):
        return side.top
    parts = dict.fromkeys(_folded(part, parts, side) for part in parts)
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
    if _is_comparable(kept):
        shorter = without_facts(kept, _facts(kept, side), side, other)
        shorter = _without_lasting_facts(shorter, side, other)
        if shorter != kept:
            return joined(operator, shorter)
        kept = _without_implied(kept, side, implication)
    kept = _grouped(_weakened(kept, side, other), side, other)
    return joined(operator, _gathered(kept, side, other))


def _folded(part: Formula, parts: Collection[Formula], side: Side) -> Formula:
    """F b instead of X F b if b is another part."""
    later = part.operands[0] if part.operator is Operator.NEXT else part
    if later is part or not side.is_far(later):
        return part
    body = later.operands[1]
    events = body.operands if body.operator is side.join else (body,)
    return later if all(event in parts for event in events) else part


def _is_comparable(parts: Sequence[Formula]) -> bool:
    """Whether the parts are few, and not all of them literals."""
    return 1 < len(parts) <= MAX_OPERANDS and any(
        f.operator not in (Operator.ATOM, Operator.NOT) for f in parts
    )


def _facts(parts: Sequence[Formula], side: Side) -> list[list[Formula]]:
    """For each F b, or F(a | b), the formulas that fail for ever if it fails."""
    found: list[list[Formula]] = []
    for part in parts:
        body = part.operands[1] if side.is_far(part) else None
        found.append(
            [] if body is None else [*(body.operands if body.operator is side.join else ()), body]
        )
    return found


def _without_lasting_facts(parts: Sequence[Formula], side: Side, other: Side) -> list[Formula]:
    """G F a | f without a in f, if f depends on no prefix: else a fails from some position on."""
    ageless = [f for f in parts if f in side.pure and f in other.pure]
    lasting = [f.operands[1] if other.is_far(f) else f for f in ageless]
    shorter = without_facts(ageless, _facts(lasting, side), side, other)
    found = dict(zip(ageless, shorter, strict=True))
    return [found.get(part, part) for part in parts]


def _without_implied(
    parts: Sequence[Formula], side: Side, implication: Implication
) -> list[Formula]:
    """a | b = b if a implies b, and true if !a does; a & c | b = c | b if !a implies b.

    (a | c) & d | b = c & d | b if a implies b.
    """
    kept = list(parts)
    for part in parts:
        others = [f for f in kept if f is not part]
        if any(implication.is_below(part, f, side) for f in others):
            kept = others
        elif any(implication.is_below(implication.opposite(part), f, side) for f in others):
            return [side.top]
        elif part.operator is side.meet and len(part.operands) <= MAX_OPERANDS:
            needed = [
                _without_those_below(x, others, side, implication)
                for x in part.operands
                if not any(implication.is_below(implication.opposite(x), f, side) for f in others)
            ]
            if needed != list(part.operands):
                kept[kept.index(part)] = joined(side.meet, needed)
                return kept
    return kept


def _without_those_below(
    part: Formula, others: Sequence[Formula], side: Side, implication: Implication
) -> Formula:
    """A disjunction without the operands that imply one of the given formulas."""
    if part.operator is not side.join or len(part.operands) > MAX_OPERANDS:
        return part
    kept = [x for x in part.operands if not any(implication.is_below(x, f, side) for f in others)]
    return joined(side.join, kept)


def _gathered(parts: list[Formula], side: Side, other: Side) -> list[Formula]:
    """F a | G F b = F(a | G F b): a run waits for both in one state."""
    waiting = next((f for f in parts if is_waiting(f, side)), None)
    ageless = [f for f in parts if f in side.pure and f in other.pure and f is not waiting]
    if waiting is None or not ageless:
        return parts
    whole = side.far(joined(side.join, [waiting.operands[1], *ageless]))
    return [whole, *(f for f in parts if f is not waiting and f not in ageless)]


def _weakened(parts: list[Formula], side: Side, other: Side) -> list[Formula]:
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
            weak = other.make(event, joined(side.join, [before, event]))
            return [weak if f is part else f for f in parts if f is not found[before]]
    return parts


def _grouped(parts: Iterable[Formula], side: Side, other: Side) -> list[Formula]:
    """The operands of a chain of |, with those joined that one formula can express."""
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


def _together(group: list[Formula], side: Side, other: Side) -> Formula:
    """One formula for the disjunction of a group."""
    first = group[0]
    if first.operator is Operator.NEXT:  # X a | X b = X(a | b)
        return next_(joined(side.join, [f.operands[0] for f in group]))
    if other.is_far(first) and side.is_far(first.operands[1]):  # G F a | G F b = G F(a | b)
        bodies = [f.operands[1].operands[1] for f in group]
        return other.far(side.far(joined(side.join, bodies)))
    if first.operator is side.fixpoint:  # a U b | a U c = a U (b | c)
        return side.make(first.operands[0], joined(side.join, [f.operands[1] for f in group]))
    # a R c | b R c = (a | b) R c
    return other.make(joined(side.join, [f.operands[0] for f in group]), first.operands[1])
