"""An automaton whose next letter has some propositions besides those that it is given."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

from companion.ltl.automaton import BuchiAutomaton, Label, Transition


def with_first_letter(
    automaton: BuchiAutomaton, states: Iterable[int], holding: frozenset[str]
) -> BuchiAutomaton:
    """The automaton from some states on, where certain propositions hold in the first letter.

    It begins in a state of its own, to which nothing leads back; the other states keep their
    numbers.

    >>> from companion.ltl.parser import parse
    >>> from companion.ltl.translate import translate
    >>> asked = translate(parse("G (asked -> F home)"))
    >>> pending = with_first_letter(asked, asked.initial, frozenset({"asked"}))
    >>> [(str(t.label), t.target) for t in pending.outgoing[asked.states]]
    [('home', 0), ('!home', 1)]

    Args:
        automaton: reads the words.
        states: where it may be.
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
