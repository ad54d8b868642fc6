"""How do other tools read our automata? Text in the Hanoi Omega-Automata format, version 1.

Transition-based generalized Büchi acceptance, explicit labels; one line a state and a transition.
Source: https://adl.github.io/hoaf/.
"""

from __future__ import annotations

from companion.ltl.automaton import BuchiAutomaton, Label


def to_hoa(automaton: BuchiAutomaton) -> str:
    """The automaton as HOA v1, with a line feed after each line."""
    number_of = {name: number for number, name in enumerate(automaton.propositions)}
    lines = [
        "HOA: v1",
        f"name: {_quoted(automaton.name)}",
        f"States: {automaton.states}",
        *(f"Start: {state}" for state in sorted(automaton.initial)),
        " ".join(["AP:", str(len(number_of)), *map(_quoted, number_of)]),
        f"acc-name: {_acceptance_name(automaton.marks)}",
        f"Acceptance: {automaton.marks} {_acceptance(automaton.marks)}",
        "properties: trans-labels explicit-labels trans-acc",
        "--BODY--",
    ]
    for state, leaving in enumerate(automaton.outgoing):
        lines.append(f"State: {state}")
        for transition in leaving:
            marks = " ".join(map(str, sorted(transition.marks)))
            line = f"[{_cube(transition.label, number_of)}] {transition.target}"
            lines.append(f"{line} {{{marks}}}" if marks else line)
    return "\n".join([*lines, "--END--", ""])


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
