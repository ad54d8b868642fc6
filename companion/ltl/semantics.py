"""The semantics of LTL on lasso words: the definition itself, without any automaton.

A lasso word is a finite prefix followed by a loop that repeats for ever. It has finitely many
distinct positions, so each subformula is a set of positions, and each temporal operator is a least
or greatest fixpoint over them. This is the independent check of every plan. `accepts` asks an
automaton the same question, for comparison.

The paper's Section II-C prints the Until rule with `a` holding for i <= j <= k, which would demand
`a & b` at position k. This is a misprint. The definition everywhere else, and here, is i <= j < k:
`b` holds at k and `a` at every position before it.

Source: Baier and Katoen, Principles of Model Checking, Definitions 5.6 and 5.7.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache

from companion.ltl.automaton import BuchiAutomaton
from companion.ltl.components import strong_components
from companion.ltl.formula import Formula, Operator, subformulas

Letter = frozenset[str]
"""The propositions that hold at one position; all others are false."""


def holds(formula: Formula, prefix: Sequence[Letter], loop: Sequence[Letter]) -> bool:
    """Whether prefix loop loop loop ... satisfies a formula at its first position.

    >>> from companion.ltl.parser import parse
    >>> a, b = frozenset({"a"}), frozenset({"b"})
    >>> holds(parse("a U b"), [a, a], [b]), holds(parse("a U b"), [], [a])
    (True, False)

    Raises:
        ValueError: the loop is empty.
    """
    if not loop:
        raise ValueError("the loop of a lasso word has at least one position")
    word = [*prefix, *loop]
    everywhere = (1 << len(word)) - 1
    where: dict[Formula, int] = {}  # positions as bits: bit i is set if it holds at position i
    for node in _parts(formula):
        if node.operator is Operator.ATOM:
            where[node] = sum(1 << i for i, letter in enumerate(word) if node.atom in letter)
        else:
            operands = [where[operand] for operand in node.operands]
            where[node] = _positions(node.operator, operands, everywhere, len(prefix))
    return bool(where[formula] & 1)


@lru_cache(maxsize=256)
def _parts(formula: Formula) -> tuple[Formula, ...]:
    """The subformulas, operands first; cached, since the same formulas check all plans."""
    return tuple(subformulas(formula))


def _positions(operator: Operator, operands: list[int], everywhere: int, loop_start: int) -> int:
    """The positions at which an operator holds, given those of its operands."""

    def next_(positions: int) -> int:
        wraps = positions >> loop_start & 1  # the last position is followed by the loop's first
        return positions >> 1 | (wraps << everywhere.bit_length() - 1)

    def eventually(positions: int) -> int:
        """All positions up to the last of these; all positions if one of these is in the loop."""
        return everywhere if positions >> loop_start else (1 << positions.bit_length()) - 1

    def fixpoint(always: int, while_next: int, start: int) -> int:
        """The positions p in `always`, or in `while_next` if p + 1 is in the result."""
        positions = start
        while (grown := always | while_next & next_(positions)) != positions:
            positions = grown
        return positions

    match operator, operands:
        case Operator.TRUE, []:
            return everywhere
        case Operator.FALSE, []:
            return 0
        case Operator.NOT, [a]:
            return everywhere & ~a
        case Operator.NEXT, [a]:
            return next_(a)
        case Operator.EVENTUALLY, [a]:
            return eventually(a)
        case Operator.ALWAYS, [a]:
            return everywhere & ~eventually(everywhere & ~a)
        case Operator.UNTIL, [a, b]:
            return fixpoint(b, a, 0)
        case Operator.WEAK_UNTIL, [a, b]:
            return fixpoint(b, a, everywhere)
        case Operator.RELEASE, [a, b]:
            return fixpoint(a & b, b, everywhere)
        case Operator.IMPLIES, [a, b]:
            return everywhere & ~a | b
        case Operator.IFF, [a, b]:
            return everywhere & ~(a ^ b)
        case Operator.AND, _:
            return _all(operands, everywhere)
        case Operator.OR, _:
            return everywhere & ~_all([~a for a in operands], everywhere)
    raise AssertionError(operator)


def _all(operands: list[int], everywhere: int) -> int:
    common = everywhere
    for positions in operands:
        common &= positions
    return common


def accepts(automaton: BuchiAutomaton, prefix: Sequence[Letter], loop: Sequence[Letter]) -> bool:
    """Whether an automaton accepts prefix loop loop loop ...

    >>> from companion.ltl.parser import parse
    >>> from companion.ltl.translate import translate
    >>> accepts(translate(parse("F G p")), [frozenset()], [frozenset({"p"})])
    True

    It does so exactly if the product of automaton and word has a reachable strongly connected
    component whose transitions carry every mark.

    Raises:
        ValueError: the loop is empty.
    """
    if not loop:
        raise ValueError("the loop of a lasso word has at least one position")
    word = [*prefix, *loop]
    number_of = {(state, 0): number for number, state in enumerate(automaton.initial)}
    pending = list(number_of)
    edges: list[list[tuple[int, frozenset[int]]]] = []
    for state, position in pending:  # grows while it is read
        after = position + 1 if position + 1 < len(word) else len(prefix)
        leaving = []
        for transition in automaton.outgoing[state]:
            if transition.label.matches(word[position]):
                target = (transition.target, after)
                if target not in number_of:
                    number_of[target] = len(number_of)
                    pending.append(target)
                leaving.append((number_of[target], transition.marks))
        edges.append(leaving)
    required = frozenset(range(automaton.marks))
    for component in strong_components([[target for target, _ in leaving] for leaving in edges]):
        inside = set(component)
        marks = [m for node in component for target, m in edges[node] if target in inside]
        if marks and required <= frozenset().union(*marks):
            return True
    return False
