"""Facts: what holds at all positions need not be said again.

G a & f is G a & f', where f' is f with true in the place of a and false in that of !a: f speaks
of no position before its own. In G(a & b) the same is done with a in b.
"""

from __future__ import annotations

from collections.abc import Sequence

from companion.ltl.formula import Formula, Operator, negate, subformulas
from companion.ltl.laws.sides import Side, joined

MAX_NODES = 400
"""Nodes of a chain up to which it is searched."""


def without_facts(
    parts: Sequence[Formula], facts: Sequence[Sequence[Formula]], side: Side, other: Side
) -> list[Formula]:
    """The parts of a chain of |, each without the facts of the others.

    Args:
        facts: for each part the formulas that fail at all positions if it does.
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
                    continue  # the first of equal ones stays
                values[fact] = side.bottom
                if fact.operator in (Operator.ATOM, Operator.NOT):
                    values[negate(fact)] = side.top
        found.append(_replaced(nodes, values, side, other))
    return found


def _nodes(part: Formula) -> list[Formula]:
    """The nodes of a formula, the formula itself last; about MAX_NODES of them at most."""
    nodes = []
    for node in subformulas(part):
        nodes.append(node)
        if len(nodes) > MAX_NODES:
            break
    return nodes


def _replaced(
    nodes: Sequence[Formula], values: dict[Formula, Formula], side: Side, other: Side
) -> Formula:
    """The last of some nodes, with values in the place of formulas.

    Where G b is known to fail, a R b is b U (a & b); where F b is known, a U b is b R (a | b).
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
