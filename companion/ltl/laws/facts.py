"""Facts: what holds at all positions need not be said again.

G a & f is G a & f', where f' is f with a replaced by true and !a by false: f is about no position
before its own. In G(a & b) the same is done with a in b.
"""

from __future__ import annotations

from collections.abc import Sequence

from companion.ltl.formula import Formula, Operator, negate, subformulas
from companion.ltl.laws.sides import Side, joined

MAX_NODES = 400
"""The most nodes of a chain that are searched."""


def without_facts(
    parts: Sequence[Formula], facts: Sequence[Sequence[Formula]], side: Side, other: Side
) -> list[Formula]:
    """The parts of a chain of |, each simplified by the facts of the others.

    Args:
        facts: for each part, the formulas that fail at all positions if the part fails.
    """
    if not any(facts):
        return list(parts)
    nodes_of = [_nodes(part) for part in parts]
    if sum(map(len, nodes_of)) > MAX_NODES:
        return list(parts)
    found = []
    for i, nodes in enumerate(nodes_of):
        values = {}
        for j, group in enumerate(facts):
            for fact in group if j != i else ():
                if j > i and fact in facts[i]:
                    continue  # of equal parts the first one stays
                values[fact] = side.bottom
                if fact.operator in (Operator.ATOM, Operator.NOT):
                    values[negate(fact)] = side.top
        found.append(_replaced(nodes, values, side, other))
    return found


def _nodes(part: Formula) -> list[Formula]:
    """The nodes of a formula, the formula itself last; at most about MAX_NODES."""
    nodes = []
    for node in subformulas(part):
        nodes.append(node)
        if len(nodes) > MAX_NODES:
            break
    return nodes


def _replaced(
    nodes: Sequence[Formula], values: dict[Formula, Formula], side: Side, other: Side
) -> Formula:
    """The last of some nodes, with formulas replaced by values.

    If G b is known to fail, a R b becomes b U (a & b); if F b is known to hold, a U b becomes b R
    (a | b).
    """
    made: dict[Formula, Formula] = {}
    for node in nodes:
        operands = tuple(made[operand] for operand in node.operands)
        if node in values:
            made[node] = values[node]
        elif node.operator is other.fixpoint and other.far(node.operands[1]) in values:
            before, event = operands
            made[node] = side.make(event, joined(side.meet, [before, event]))
        else:
            made[node] = Formula(node.operator, operands, node.atom)
    return made[nodes[-1]]
