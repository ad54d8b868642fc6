"""Translation: an automaton that accepts exactly the words that satisfy a formula.

    translate:    formula -> normal form -> simplify -> tableau -> reductions -> automaton
    state_based:  automaton -> degeneralisation -> reductions -> automaton

With few letters, intermediate labels are sets of letters, which gives smaller automata, and the
conjuncts are translated and reduced separately (`decomposition.py`, `construction.py`). Otherwise
labels stay cubes.
"""

from __future__ import annotations

from companion.ltl.automaton import BuchiAutomaton
from companion.ltl.budget import Budget, TranslationLimit
from companion.ltl.conjuncts import conjuncts
from companion.ltl.construction import Construction
from companion.ltl.decomposition import decomposed
from companion.ltl.formula import Formula, atoms, negation_normal_form
from companion.ltl.graph import automaton_of, graph_of, with_cubes, with_letters
from companion.ltl.labels import Alphabet
from companion.ltl.reductions.degeneralisation import degeneralised
from companion.ltl.reductions.strategy import (
    reduced_by_states,
    reduced_cubes,
    reduced_cubes_by_states,
)
from companion.ltl.simplify import simplified
from companion.ltl.tableau import unfolded

MAX_STATES = 10_000

LEAST_STEPS = 25_000
"""What any formula costs at least; it matters if thousands of conjuncts share one budget."""

EXTRA_STEPS = 12_000_000
EXTRA_BYTES = 100_000_000
"""The budget for making an automaton smaller; once it is spent, the automaton stays as it is."""


def translate(
    formula: Formula,
    *,
    exclusive: frozenset[str] = frozenset(),
    max_states: int = MAX_STATES,
    budget: Budget | None = None,
) -> BuchiAutomaton:
    """An automaton that accepts exactly the words that satisfy a formula.

    State 0 is its only initial state. From every other state some word is accepted.

    >>> from companion.ltl.parser import parse
    >>> automaton = translate(parse("G F p"))
    >>> automaton.states, [(str(t.label), set(t.marks)) for t in automaton.transitions]
    (1, [('p', {0}), ('!p', set())])

    Args:
        exclusive: propositions of which at most one holds at a time; letters with two of them may
            be accepted or not.
        max_states: the most states, and transitions of one state, that are made before reduction.
        budget: what may be spent; a new one by default.

    Raises:
        TranslationLimit: `max_states` or the budget does not suffice.
    """
    try:
        return _translated(formula, exclusive, max_states, budget or Budget())
    except TranslationLimit as limit:
        if len(conjuncts(formula)) > 1:
            raise limit.for_conjunction() from None
        raise


def _translated(
    formula: Formula, exclusive: frozenset[str], max_states: int, budget: Budget
) -> BuchiAutomaton:
    budget.spend(LEAST_STEPS)
    normal = negation_normal_form(formula)
    simple = simplified(normal, budget)
    alphabet = Alphabet(sorted(atoms(normal)), exclusive)
    with budget.spared(EXTRA_STEPS, EXTRA_BYTES) as extra:
        if alphabet.is_small:
            construction = Construction(alphabet, max_states, budget, extra)
            graph = with_cubes(decomposed(simple, construction), alphabet, budget)
        else:
            rough = unfolded(simple, alphabet, max_states, budget)
            budget.keep(3 * rough.size[1])  # they exist at the same time in several forms
            graph = reduced_cubes(rough, extra)
    return automaton_of(graph, alphabet, str(formula))


def state_based(automaton: BuchiAutomaton, budget: Budget | None = None) -> BuchiAutomaton:
    """An equivalent automaton whose one acceptance set is a set of states.

    The transitions of an accepting state carry mark 0, and no others do.

    >>> from companion.ltl.parser import parse
    >>> state_based(translate(parse("G F p"))).states
    2

    Args:
        budget: what may be spent; a new one by default.

    Raises:
        TranslationLimit: the budget does not suffice.
    """
    budget = budget or Budget()
    alphabet = Alphabet(automaton.propositions, automaton.exclusive)
    cubes = graph_of(automaton, alphabet)
    if alphabet.is_small:
        candidates = degeneralised(with_letters(cubes, alphabet, budget), budget)
        graph = with_cubes(reduced_by_states(candidates, budget), alphabet, budget)
    else:
        with budget.spared(EXTRA_STEPS, EXTRA_BYTES) as extra:
            graph = reduced_cubes_by_states(degeneralised(cubes, budget)[0], extra)
    return automaton_of(graph, alphabet, automaton.name)
