"""The command that shows the automata of formulas: ltl."""

from __future__ import annotations

from dataclasses import asdict
from enum import StrEnum
from typing import Annotated

import typer


class Form(StrEnum):
    """How `ltl` prints an automaton."""

    HOA = "hoa"
    DOT = "dot"
    STATS = "stats"


def ltl(
    formula: Annotated[str, typer.Argument(help="e.g. 'G (F at(A) | targetFound)'")],
    form: Annotated[
        Form, typer.Option("--format", help="HOA v1, Graphviz, or how large it is.")
    ] = Form.HOA,
    by_states: Annotated[
        bool, typer.Option("--state-based", help="Accept by states and not by transitions.")
    ] = False,
) -> None:
    """Prints the Büchi automaton of a formula; mission patterns such as visit(A, B) are known."""
    from companion.ltl.automaton import state_based, statistics
    from companion.ltl.dot import to_dot
    from companion.ltl.hoa import to_hoa
    from companion.ltl.parser import parse
    from companion.ltl.translate import translate

    automaton = translate(parse(formula))
    if by_states:
        automaton = state_based(automaton)
    match form:
        case Form.HOA:
            typer.echo(to_hoa(automaton, marks_on_states=by_states).rstrip())
        case Form.DOT:
            typer.echo(to_dot(automaton).rstrip())
        case Form.STATS:
            for name, value in asdict(statistics(automaton)).items():
                typer.echo(f"{name.replace('_', ' '):<18} {value}")
