"""Formulas of linear temporal logic, and their automata."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from companion.arguments import check_kind, names_of

if TYPE_CHECKING:
    from companion.ltl.automaton import BuchiAutomaton
    from companion.ltl.formula import Formula


def parse_formula(text: str) -> Formula:
    """Parses a formula.

    A formula consists of propositions such as `targetFound` or `at(A)`, of true, false and
    parentheses, of ! & | -> <->, of X (next), F (eventually), G (always), U (until), R (release), W
    (weak until), and of mission patterns such as `patrolling(A, B)`.

    >>> from companion import parse_formula
    >>> parse_formula("patrolling(A, B)") is parse_formula("G F at(A) & G F at(B)")
    True

    Raises:
        FormulaError: the text is no formula; a caret marks what cannot be read.
        CompanionError: `text` is no string.
    """
    from companion.ltl.parser import parse

    check_kind(text, str, "the text of a formula")
    return parse(text)


def translate(formula: Formula | str, *, exclusive: Iterable[str] = ()) -> BuchiAutomaton:
    """A Büchi automaton that accepts exactly the words that satisfy a formula.

    >>> from companion import to_dot, translate
    >>> automaton = translate("G (found -> X at(Home))")
    >>> automaton.states, automaton.propositions
    (2, ('at(Home)', 'found'))
    >>> to_dot(automaton).startswith("digraph")
    True

    Args:
        formula: one of `parse_formula`, or its text.
        exclusive: propositions of which at most one holds at a time; the automaton may then be
            smaller.

    Raises:
        FormulaError: the text is no formula.
        TranslationLimit: the automaton would be too large, or take too long.
        CompanionError: `formula` is neither a formula nor a string.
    """
    from companion.ltl import translate as translation
    from companion.ltl.formula import Formula

    made = parse_formula(formula) if isinstance(formula, str) else formula
    check_kind(made, Formula, "a formula, or its text")
    return translation.translate(made, exclusive=names_of(exclusive, "propositions"))
