"""The command that shows the automata of formulas: ltl."""

from __future__ import annotations

import re
import time
from collections.abc import Iterable
from dataclasses import astuple, dataclass, replace
from difflib import get_close_matches
from enum import StrEnum
from typing import TYPE_CHECKING, Annotated

import typer

from companion.errors import FormulaError, Location, MissionError

if TYPE_CHECKING:
    from companion.ltl.automaton import BuchiAutomaton
    from companion.ltl.budget import Budget
    from companion.ltl.formula import Formula


class Form(StrEnum):
    """Output formats of `ltl`."""

    HOA = "hoa"
    DOT = "dot"
    STATS = "stats"


COLUMNS = (
    "states",
    "transitions",
    "marks",
    "propositions",
    "deterministic",
    "complete",
    "milliseconds",
    "formula",
)
"""The columns of --format stats; --batch adds a column `line` before them."""
_NEAR = 0.75
"""Similarity above which names are alike, such as `patrol` and `patrolling`."""
BatchFile = Annotated[
    typer.FileText | None,
    typer.Option(
        metavar="FILE",
        encoding="utf-8-sig",
        errors="replace",  # the parser points to the character that could not be decoded
        help="Read formulas from a file, one per line; - is standard input.",
    ),
]
Exclusive = Annotated[
    str,
    typer.Option(metavar="NAMES", help="Propositions of which at most one holds at a time."),
]


def ltl(
    formula: Annotated[
        str | None,
        typer.Argument(metavar="FORMULA", help="A formula, e.g. 'G (F at(A) | targetFound)'."),
    ] = None,
    form: Annotated[
        Form,
        typer.Option("--format", help="hoa: HOA v1; dot: for Graphviz; stats: a table of sizes."),
    ] = Form.HOA,
    by_states: Annotated[
        bool,
        typer.Option(
            "--state-based", help="Print automata that accept by states, not by transitions."
        ),
    ] = False,
    monolithic: Annotated[
        bool, typer.Option("--monolithic", help="Print one automaton for the whole formula.")
    ] = False,
    batch: BatchFile = None,
    exclusive: Exclusive = "",
) -> None:
    """Prints the Büchi automata of a formula of linear temporal logic.

    The formula is split as the planner does it: at &, at G over &, and at & under
    |. Each part gets its own automaton. A formula consists of propositions such
    as targetFound or at(A), true, false, ( ), ! & | -> <->, X (next), F
    (eventually), G (always), U (until), R (release), W (weak until), and mission
    patterns such as patrolling(A, B).

    \b
    Examples:
      companion ltl 'G (F at(A) | targetFound)'
      companion ltl 'patrolling(A, B, C)' --format stats
      companion ltl 'F at(A) & F at(B)' --monolithic --exclusive 'at(A), at(B)'
      companion ltl 'F at(A)' --format dot | dot -Tsvg > automaton.svg
      companion ltl --batch formulas.txt --format stats > sizes.tsv

    In a file, blank lines and lines that begin with # are skipped. The name of
    each automaton begins with the file and the line. If a formula cannot be read,
    or its automaton is too large, the command reports its place, prints all
    others, and ends with exit code 2.
    """
    if (formula is None) == (batch is None):
        raise typer.BadParameter("give either a formula or --batch FILE", param_hint="FORMULA")
    request = _Request(form, by_states, monolithic, _propositions(exclusive))
    if form is Form.STATS:
        _print_row(COLUMNS if batch is None else ("line", *COLUMNS))
    if formula is not None:
        request.print_automata(formula)
    if batch is not None:
        _print_all(batch, "<stdin>" if batch.name == "-" else batch.name, request)


def _propositions(names: str) -> frozenset[str]:
    """The propositions in a list such as `at(A), ok(A, B)`."""
    from companion.ltl.parser import atom

    comma_outside_brackets = r",(?![^(]*\))"
    found = set()
    for name in re.split(comma_outside_brackets, names) if names else ():
        try:
            found.add(atom(name).atom)
        except FormulaError as error:
            what = f"{name.strip()!r} is not a proposition such as at(A)"
            raise typer.BadParameter(what, param_hint="--exclusive") from error
    return frozenset(found)


@dataclass(frozen=True, slots=True)
class _Request:
    """The options of the command."""

    form: Form
    by_states: bool
    monolithic: bool
    exclusive: frozenset[str]

    def print_automata(self, text: str, line: Location | None = None) -> None:
        """All automata of a formula, or none. Raises FormulaError and TranslationLimit.

        Args:
            line: where the formula comes from; printed with each automaton.
        """
        from companion.ltl.budget import Budget
        from companion.ltl.conjuncts import conjuncts
        from companion.ltl.parser import parse

        formula, budget = parse(text), Budget()
        _notice_patterns(formula)
        parts = (formula,) if self.monolithic else conjuncts(formula)
        for automaton, milliseconds in [self._translated(part, budget) for part in parts]:
            self._print(automaton, milliseconds, line)

    def _translated(self, formula: Formula, budget: Budget) -> tuple[BuchiAutomaton, float]:
        """An automaton, and its translation time in milliseconds."""
        from companion.ltl.translate import state_based, translate

        began_s = time.perf_counter()
        automaton = translate(formula, exclusive=self.exclusive, budget=budget)
        if self.by_states:
            automaton = state_based(automaton, budget)
        return automaton, 1000 * (time.perf_counter() - began_s)

    def _print(self, automaton: BuchiAutomaton, milliseconds: float, line: Location | None) -> None:
        from companion.ltl.automaton import statistics
        from companion.ltl.dot import to_dot
        from companion.ltl.hoa import to_hoa

        if self.form is Form.STATS:
            *counts, is_deterministic, is_complete = astuple(statistics(automaton))
            verdicts = ["yes" if x else "no" for x in (is_deterministic, is_complete)]
            cells = [*counts, *verdicts, f"{milliseconds:.2f}", automaton.name]
            _print_row(cells if line is None else [line.line, *cells])
            return
        if line is not None:
            automaton = replace(automaton, name=f"{line.path}:{line.line}: {automaton.name}")
        if self.form is Form.DOT:
            typer.echo(to_dot(automaton), nl=False)
        else:
            typer.echo(to_hoa(automaton, marks_on_states=self.by_states), nl=False)


def _notice_patterns(formula: Formula) -> None:
    """Prints which propositions have nearly the name of a mission pattern."""
    from companion.ltl.formula import atoms
    from companion.ltl.patterns import PATTERNS

    for proposition in sorted(atoms(formula)):
        name, bracket, _ = proposition.partition("(")
        near = get_close_matches(name.lower(), PATTERNS, 1, _NEAR) if bracket else []
        for pattern in near:
            signature = PATTERNS[pattern].signature
            notice = f"{proposition} is read as a proposition. Did you mean {signature}?"
            typer.echo(f"notice     {notice}", err=True)


def _print_row(cells: Iterable[object]) -> None:
    typer.echo("\t".join(map(str, cells)))


def _print_all(lines: Iterable[str], path: str, request: _Request) -> None:
    """Prints the automata of a file of formulas. Raises MissionError at the end if any failed."""
    from companion.ltl.budget import TranslationLimit

    tried = failed = 0
    for number, line in enumerate(lines, 1):
        text = line.rstrip()
        start = len(text) - len(text.lstrip())
        if not text or text[start] == "#":
            continue
        tried += 1
        try:
            request.print_automata(text, Location(path, number, start + 1))
        except FormulaError as error:
            failed += 1
            typer.echo(str(error.located(Location(path, number, error.offset + 1))), err=True)
        except TranslationLimit as error:
            failed += 1
            typer.echo(str(error.located(Location(path, number, start + 1))), err=True)
    if failed:
        raise MissionError(f"{failed} of {tried} formulas in {path} have no automaton")
