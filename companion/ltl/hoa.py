"""Automata as text that other tools read: the Hanoi Omega-Automata format, version 1.

Acceptance is generalized Büchi, marks are on transitions or on states, and labels are explicit.
Each state and each transition has one line. Several texts in a row are a stream of automata.
Source: https://adl.github.io/hoaf/.
"""

from __future__ import annotations

from companion.arguments import check_kind
from companion.ltl.automaton import BuchiAutomaton, Label, statistics


def to_hoa(automaton: BuchiAutomaton, marks_on_states: bool = False) -> str:
    """The automaton as HOA v1, with a line feed after each line.

    >>> from companion.ltl.parser import parse
    >>> from companion.ltl.translate import translate
    >>> print(to_hoa(translate(parse("G F p"))).partition("--BODY--")[2], end="")
    <BLANKLINE>
    State: 0
    [0] 0 {0}
    [!0] 0
    --END--

    Args:
        marks_on_states: whether to write marks once for each state, for tools that know no others.

    Raises:
        ValueError: marks on states are requested, but the automaton has no state acceptance.
        CompanionError: the argument is not an automaton.
    """
    check_kind(automaton, BuchiAutomaton, "an automaton, as of translate")
    if marks_on_states and not automaton.has_state_acceptance:
        raise ValueError("some state has transitions with different marks")
    number_of = {name: number for number, name in enumerate(automaton.propositions)}
    lines = [
        "HOA: v1",
        f"name: {_quoted(automaton.name)}",
        f"States: {automaton.states}",
        *(f"Start: {state}" for state in sorted(automaton.initial)),
        " ".join(["AP:", str(len(number_of)), *map(_quoted, number_of)]),
        f"acc-name: {_acceptance_name(automaton.marks)}",
        f"Acceptance: {automaton.marks} {_acceptance(automaton.marks)}",
        f"properties: trans-labels explicit-labels {'state' if marks_on_states else 'trans'}-acc",
        *_verdicts(automaton),
        "--BODY--",
    ]
    for state, leaving in enumerate(automaton.outgoing):
        if marks_on_states:
            common = leaving[0].marks if leaving else frozenset()
            lines.append(f"State: {state}{_marks(common)}")
        else:
            lines.append(f"State: {state}")
        for transition in leaving:
            line = f"[{_cube(transition.label, number_of)}] {transition.target}"
            lines.append(line if marks_on_states else line + _marks(transition.marks))
    return "\n".join([*lines, "--END--", ""])


def _verdicts(automaton: BuchiAutomaton) -> list[str]:
    """Properties that tools then need not compute; a property not named may hold or not."""
    figures = statistics(automaton)
    held = {"deterministic": figures.is_deterministic, "complete": figures.is_complete}
    names = [name for name, is_held in held.items() if is_held]
    return [" ".join(["properties:", *names])] if names else []


def _marks(marks: frozenset[int]) -> str:
    return f" {{{' '.join(map(str, sorted(marks)))}}}" if marks else ""


def _quoted(text: str) -> str:
    escaped = text.replace("\\", "\\\\").replace('"', '\\"')
    return f'"{escaped}"'


def _acceptance_name(marks: int) -> str:
    return {0: "all", 1: "Buchi"}.get(marks, f"generalized-Buchi {marks}")


def _acceptance(marks: int) -> str:
    return "&".join(f"Inf({mark})" for mark in range(marks)) or "t"


def _cube(label: Label, number_of: dict[str, int]) -> str:
    signs = dict.fromkeys(label.positive, "") | dict.fromkeys(label.negative, "!")
    literals = sorted((number_of[name], sign) for name, sign in signs.items())
    return "&".join(f"{sign}{number}" for number, sign in literals) or "t"
