"""Spot as a peer: its automata for our formulas, where it is installed.

The extra `test` installs it where it has a wheel: `spottl`, for Linux on x86-64.
"""

from __future__ import annotations

from typing import Any

from companion.ltl.formula import Formula, Operator, subformulas

try:
    import spot
except ImportError:
    spot = None

NAME = f"Spot {spot.version()}" if spot is not None else None
"""Its name with its version; None where it is missing."""

KINDS = {"generalized": ("GeneralizedBuchi",), "state-based": ("Buchi", "SBAcc")}
"""Spot's names of our kinds of automata. It minimises them as `ltl2tgba` does."""


def spot_text(formula: Formula) -> str:
    """A formula for Spot, with each operator in brackets, because Spot binds -> and <-> alike."""
    text: dict[Formula, str] = {}
    for node in subformulas(formula):
        operands = [text[operand] for operand in node.operands]
        if node.operator is Operator.ATOM:
            text[node] = f'"{node.atom}"'
        elif len(operands) < 2:
            text[node] = f"{node.operator.value}{''.join(operands)}"
        else:
            text[node] = f"({f' {node.operator.value} '.join(operands)})"
    return text[formula]


def automata(formula: Formula) -> dict[str, Any]:
    """Spot's automaton of each kind."""
    text = spot_text(formula)
    return {name: spot.translate(text, *kind) for name, kind in KINDS.items()}


def sizes(formula: Formula) -> dict[str, tuple[int, int]]:
    """States and edges of Spot's automaton of each kind; an edge may have any label."""
    found = {}
    for name, automaton in automata(formula).items():
        automaton.merge_edges()
        found[name] = (automaton.num_states(), automaton.num_edges())
    return found
