"""Decomposition: the graph of a conjunction from the graphs of its parts.

Conjuncts that share no proposition are translated apart and intersected. Of the others, those that
have weak deterministic automata are tried apart from the rest, and the smaller graph is taken.
"""

from __future__ import annotations

from collections import defaultdict
from dataclasses import replace
from functools import partial, reduce

from companion.ltl.budget import Budget, TranslationLimit
from companion.ltl.construction import MAX_STATES_AGAIN, Construction
from companion.ltl.formula import FALSE, TRUE, Formula, Operator, atoms, conjoin, release
from companion.ltl.graph import LabelledGraph, is_deterministic
from companion.ltl.intersection import intersection
from companion.ltl.labels import LetterSet
from companion.ltl.reductions.recurrence import is_recurrence
from companion.ltl.reductions.strategy import reduced
from companion.ltl.reductions.trimming import trimmed
from companion.ltl.simplify import simplified


def decomposed(formula: Formula, construction: Construction) -> LabelledGraph[LetterSet]:
    """The graph of a simplified formula, intersected from those of its independent parts.

    Raises:
        TranslationLimit: the construction's limit or budget does not suffice.
    """
    groups = _independent(formula, construction.alphabet.exclusive, construction.budget)
    graphs = [_smaller(group, construction) for group in groups]
    whole = reduce(partial(intersection, budget=construction.budget), graphs)
    if len(graphs) == 1 or all(map(is_deterministic, graphs)):
        return trimmed(whole)  # there is nothing more to merge
    return reduced(whole, construction.extra)


def _independent(formula: Formula, exclusive: frozenset[str], budget: Budget) -> list[Formula]:
    """Formulas whose conjunction is the given one, and that share no proposition."""
    groups: list[tuple[frozenset[str], list[Formula]]] = []
    for part in _conjuncts(formula, budget):
        names, together = atoms(part), [part]
        if names & exclusive:
            names |= exclusive
        for group in [known for known in groups if known[0] & names]:
            groups.remove(group)
            names, together = names | group[0], group[1] + together
        groups.append((names, together))
    if len(groups) == 1:
        return [formula]
    return [simplified(conjoin(*together), budget) for _, together in groups]


def _smaller(formula: Formula, construction: Construction) -> LabelledGraph[LetterSet]:
    """The smaller graph: of all conjuncts, or with those that are obligations apart."""
    whole = construction.construct(formula)
    if whole.is_weak or not 1 < len(whole.graph.edges) <= MAX_STATES_AGAIN:
        return whole.graph
    try:
        product = _parted(formula, replace(construction, budget=construction.extra))
    except TranslationLimit:
        return whole.graph
    return min(whole.graph, product or whole.graph, key=lambda graph: len(graph.edges))


def _parted(formula: Formula, construction: Construction) -> LabelledGraph[LetterSet] | None:
    """From obligations, other conjuncts, and each G F apart; None if all are of one kind."""
    parts = _conjuncts(formula, construction.budget)
    if not parts[1:]:
        return None
    groups: dict[object, list[Formula]] = defaultdict(list)
    for part in parts:
        groups[part if is_recurrence(part) else construction.construct(part).is_weak].append(part)
    if not groups.keys() - {False} or not groups.keys() - {True}:
        return None
    graphs = [
        construction.construct(simplified(conjoin(*group), construction.budget)).graph
        for group in groups.values()
    ]
    product = reduce(partial(intersection, budget=construction.budget), graphs)
    return reduced(product, construction.extra)


def _conjuncts(formula: Formula, budget: Budget) -> list[Formula]:
    """The conjuncts of a simplified formula, split at & and at G over &; simplified as well."""
    parts: list[Formula] = []
    for part in formula.operands if formula.operator is Operator.AND else (formula,):
        event, kept = part.operands if part.operator is Operator.RELEASE else (TRUE, part)
        if event is FALSE and kept.operator is Operator.AND:
            parts += [simplified(release(FALSE, operand), budget) for operand in kept.operands]
        else:
            parts.append(part)
    return parts
