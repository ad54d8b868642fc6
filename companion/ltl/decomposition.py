"""Decomposition: makes the graph of a conjunction from the graphs of its parts.

1. Groups of conjuncts that share no proposition are translated separately and intersected.
2. Of other conjuncts, those with weak deterministic automata are tried separately from the rest. So
   is each conjunct that depends on no finite prefix.
3. In a disjunction, operands with weak deterministic automata run beside the rest (`union.py`).
4. An a U b that the other conjuncts imply is left out, as in Spot (Duret-Lutz, LTL translation
   improvements in Spot 1.0, IJCCBS 2014). Spot leaves out all of them, this module only those that
   make the automaton larger.

The smallest graph is the result.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import replace

from companion.ltl.budget import Budget, TranslationLimit
from companion.ltl.construction import MAX_STATES_AGAIN, Construction
from companion.ltl.formula import (
    FALSE,
    TRUE,
    Formula,
    Operator,
    atoms,
    conjoin,
    disjoin,
    negate,
    negation_normal_form,
    release,
    subformulas,
    until,
)
from companion.ltl.graph import LabelledGraph, is_deterministic
from companion.ltl.intersection import intersection
from companion.ltl.labels import LetterSet
from companion.ltl.laws.sides import is_ageless
from companion.ltl.reductions.strategy import reduced
from companion.ltl.reductions.trimming import trimmed
from companion.ltl.simplify import simplified
from companion.ltl.union import union


def decomposed(formula: Formula, construction: Construction) -> LabelledGraph[LetterSet]:
    """The graph of a simplified formula, intersected from those of its independent parts.

    Raises:
        TranslationLimit: the construction's limit or budget does not suffice.
    """
    groups = _independent(formula, construction.alphabet.exclusive, construction.budget)
    graphs = {group: _smaller(group, construction) for group in groups}
    whole = _intersected(graphs, construction.budget)
    if len(graphs) == 1 or all(map(is_deterministic, graphs.values())):
        return trimmed(whole)  # nothing more can be merged
    return reduced(whole, construction.extra)


def _intersected(
    graphs: Mapping[Formula, LabelledGraph[LetterSet]], budget: Budget
) -> LabelledGraph[LetterSet]:
    """The intersection of the graphs of formulas; those that depend on no prefix come last."""
    first, *others = sorted(graphs, key=is_ageless)
    whole = graphs[first]
    for formula in others:
        whole = intersection(whole, graphs[formula], budget, suspending=is_ageless(formula))
    return whole


def _independent(formula: Formula, exclusive: frozenset[str], budget: Budget) -> list[Formula]:
    """Formulas that share no proposition and whose conjunction is the given one."""
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
    """The smallest graph: of all conjuncts, of the necessary ones, or of separate parts."""
    whole = construction.construct(formula)
    if whole.is_weak or not 1 < len(whole.graph.edges) <= MAX_STATES_AGAIN:
        return whole.graph
    found = [whole.graph]
    extra = replace(construction, budget=construction.extra)
    try:
        needed = _without_implied(formula, extra)
        if needed is not formula:
            found.append(extra.construct(needed).graph)
        found += _parted(needed, extra)
        found += _united(needed, extra)
    except TranslationLimit:
        pass  # what was found so far is correct as well
    return min(found, key=lambda graph: (*graph.size[:2], not is_deterministic(graph)))


def _without_implied(formula: Formula, construction: Construction) -> Formula:
    """A conjunction without each a U b that the others imply; it accepts the same words."""
    if formula.operator is not Operator.AND:
        return formula
    parts = list(formula.operands)
    for part in [f for f in parts if f.operator is Operator.UNTIL]:
        others = [f for f in parts if f is not part]
        opposite = negation_normal_form(negate(part))
        if _may_imply(others, part) and construction.is_empty(conjoin(*others, opposite)):
            parts = others
    if len(parts) == len(formula.operands):
        return formula
    return simplified(conjoin(*parts), construction.budget)


def _may_imply(others: Sequence[Formula], until: Formula) -> bool:
    """Whether formulas mention what a U b waits for, and themselves wait for something."""
    nodes = set(subformulas(conjoin(*others)))
    awaited = atoms(until.operands[1])
    return any(f.operator is Operator.UNTIL for f in nodes) and awaited <= {f.atom for f in nodes}


def _parted(formula: Formula, construction: Construction) -> list[LabelledGraph[LetterSet]]:
    """The graph of obligations, other conjuncts, and ageless ones apart; none if all are alike."""
    parts = _conjuncts(formula, construction.budget)
    if not parts[1:]:
        return []
    groups: dict[object, list[Formula]] = defaultdict(list)
    for part in parts:
        groups[part if is_ageless(part) else construction.construct(part).is_weak].append(part)
    if not groups.keys() - {False} or not groups.keys() - {True}:
        return []
    conjunctions = [simplified(conjoin(*group), construction.budget) for group in groups.values()]
    graphs = {part: construction.construct(part).graph for part in conjunctions}
    return [reduced(_intersected(graphs, construction.budget), construction.extra)]


def _united(formula: Formula, construction: Construction) -> list[LabelledGraph[LetterSet]]:
    """The graph of a disjunction, with obligations and other operands followed at the same time."""
    parts = _disjuncts(formula, construction.budget)
    if not parts[1:]:
        return []
    groups: dict[bool, list[Formula]] = {True: [], False: []}
    for part in parts:
        groups[construction.construct(part).is_weak].append(part)
    if not groups[True] or not groups[False]:
        return []
    obligation, rest = (
        simplified(disjoin(*groups[is_weak]), construction.budget) for is_weak in (True, False)
    )
    weak, other = construction.construct(obligation), construction.construct(rest).graph
    if not weak.is_weak or not other.marks:
        return []
    every, suspending = construction.alphabet.every, is_ageless(rest)
    both = union(weak.graph, other, every, construction.budget, suspending=suspending)
    return [reduced(both, construction.extra)]


def _conjuncts(formula: Formula, budget: Budget) -> list[Formula]:
    """The conjuncts of a simplified formula, split at & and at G over &; also simplified."""
    parts: list[Formula] = []
    for part in formula.operands if formula.operator is Operator.AND else (formula,):
        event, kept = part.operands if part.operator is Operator.RELEASE else (TRUE, part)
        if event is FALSE and kept.operator is Operator.AND:
            parts += [simplified(release(FALSE, operand), budget) for operand in kept.operands]
        else:
            parts.append(part)
    return parts


def _disjuncts(formula: Formula, budget: Budget) -> list[Formula]:
    """The disjuncts of a simplified formula, split at | and at F over |; also simplified."""
    if formula.operator is Operator.OR:
        return list(formula.operands)
    if formula.operator is Operator.UNTIL:
        before, event = formula.operands
        if before is TRUE and event.operator is Operator.OR:
            return [simplified(until(TRUE, operand), budget) for operand in event.operands]
    return [formula]
