"""Makes an automaton that adds some propositions to the first letter that it reads."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

from companion.ltl.automaton import BuchiAutomaton, Label, Transition


def with_first_letter(
    automaton: BuchiAutomaton, states: Iterable[int], holding: frozenset[str]
) -> BuchiAutomaton:
    """The automaton, started in some states, as if certain propositions held in the first letter.

    It begins in a new state that no transition enters; the other states keep their numbers.

    >>> from companion.ltl.parser import parse
    >>> from companion.ltl.translate import translate
    >>> asked = translate(parse("G (asked -> F home)"))
    >>> pending = with_first_letter(asked, asked.initial, frozenset({"asked"}))
    >>> [(str(t.label), t.target) for t in pending.outgoing[asked.states]]
    [('home', 0), ('!home', 1)]

    Args:
        automaton: the automaton that reads the words.
        states: the states that it may be in.
        holding: propositions that hold in the first letter.
    """
    start, unmarked = automaton.states, frozenset[int]()
    first = dict.fromkeys(
        Transition(start, Label(t.label.positive - holding, t.label.negative), t.target, unmarked)
        for state in sorted(states)
        for t in automaton.outgoing[state]
        if t.label.negative.isdisjoint(holding)
    )
    return replace(
        automaton,
        states=start + 1,
        initial=frozenset({start}),
        transitions=(*automaton.transitions, *first),
    )
