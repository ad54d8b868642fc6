"""Automata as drawings, in the DOT language of Graphviz.

States are circles, and an arrow from nowhere leads to each initial state. The text of an edge is
its label and, below it, its marks. If the only acceptance set is a set of states, these are drawn
with a double line instead.

Source: https://graphviz.org/doc/info/lang.html.
"""

from __future__ import annotations

from companion.arguments import check_kind
from companion.ltl.automaton import BuchiAutomaton, Transition


def to_dot(automaton: BuchiAutomaton) -> str:
    """The automaton as a directed graph, with a line feed after each line.

    >>> from companion.ltl.parser import parse
    >>> from companion.ltl.translate import translate
    >>> print(to_dot(translate(parse("G F p"))), end="")
    digraph "G F p" {
      rankdir=LR
      node [shape=circle]
      start0 [shape=point]
      start0 -> 0
      0
      0 -> 0 [label="p\\n{0}"]
      0 -> 0 [label="!p"]
    }

    Raises:
        CompanionError: the argument is not an automaton.
    """
    check_kind(automaton, BuchiAutomaton, "an automaton, as of translate")
    on_states = automaton.marks == 1 and automaton.has_state_acceptance
    lines = [f"digraph {_quoted(automaton.name)} {{", "  rankdir=LR", "  node [shape=circle]"]
    for state in sorted(automaton.initial):
        lines += [f"  start{state} [shape=point]", f"  start{state} -> {state}"]
    for state, leaving in enumerate(automaton.outgoing):
        is_accepting = on_states and any(transition.marks for transition in leaving)
        lines.append(f"  {state} [shape=doublecircle]" if is_accepting else f"  {state}")
        lines += [f"  {_edge(transition, on_states)}" for transition in leaving]
    return "\n".join([*lines, "}", ""])


def _edge(transition: Transition, marks_on_states: bool) -> str:
    label = _quoted(str(transition.label))
    if transition.marks and not marks_on_states:
        marks = ", ".join(map(str, sorted(transition.marks)))
        label = f'{label[:-1]}\\n{{{marks}}}"'  # \n is DOT's own line break
    return f"{transition.source} -> {transition.target} [label={label}]"


def _quoted(text: str) -> str:
    escaped = text.replace("\\", "\\\\").replace('"', '\\"')
    return f'"{escaped}"'
