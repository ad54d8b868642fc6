"""Strategy: decides which reductions are made in which order, until none helps any more.

Trimming and quotients alternate until the size no longer changes. Graphs with sets of letters are
merged first by bisimulation, which is quick, then by simulation in both directions. Graphs with
cubes are merged by simulation, and sharpened. All this spends from a budget; when it is spent, the
graph stays as it is.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial

from companion.ltl.budget import Budget, TranslationLimit
from companion.ltl.graph import LabelledGraph, Nodes
from companion.ltl.labels import Cube, L, LetterSet
from companion.ltl.reductions.bisimulation import Arrows, bisimilar
from companion.ltl.reductions.quotient import Relation, merged, merged_backwards, merged_cubes
from companion.ltl.reductions.sharpening import sharpened
from companion.ltl.reductions.simulation import simulators
from companion.ltl.reductions.trimming import Departures, trimmed, trimmed_by_states

MAX_SIMULATED = 400
"""The most states for which simulation by letters is computed."""

MAX_STATES_TWICE = 100
"""The most states for which a graph is reduced in both ways, to take the smaller result."""

FIRST_STEPS = 8_000_000
"""The steps for reducing the most promising of several graphs."""

OTHER_STEPS = 200_000
"""The steps for reducing all other graphs."""


def reduced(graph: LabelledGraph[LetterSet], budget: Budget) -> LabelledGraph[LetterSet]:
    """An equivalent graph, usually smaller; not as small as possible if the budget runs out.

    Edges between components may have any marks, and no choice is best for all automata.
    """
    best = _merged_in_turn(trimmed(graph), Departures.UNMARKED, budget)
    if not 1 < len(best.edges) <= MAX_STATES_TWICE:
        return best
    for departures, known in ((Departures.AS_GIVEN, graph), (Departures.MARKED, best)):
        start = trimmed(known, departures)
        if start != trimmed(known):
            other = trimmed(_merged_in_turn(start, departures, budget))
            best = min(best, other, key=lambda found: found.size)
    return best


def _merged_in_turn(
    best: LabelledGraph[LetterSet], departures: Departures, budget: Budget
) -> LabelledGraph[LetterSet]:
    try:
        for relation in _relations(budget):
            merge = partial(_merged_both_ways, relation=relation, departures=departures)
            best = _repeated(merge, best)
    except TranslationLimit:
        pass  # what was found so far is correct as well
    return best


def _merged_both_ways(
    graph: LabelledGraph[LetterSet], relation: Relation, departures: Departures
) -> LabelledGraph[LetterSet]:
    smaller = trimmed(merged(graph, relation), departures)
    return trimmed(merged_backwards(smaller, (), relation), departures)


def _relations(budget: Budget) -> tuple[Relation, Relation]:
    """Bisimulation, and simulation up to some number of states."""

    def simulating(arrows: Arrows, colours: Sequence[int]) -> list[Nodes]:
        if len(arrows) > MAX_SIMULATED:
            raise TranslationLimit(f"{MAX_SIMULATED} states to compare")
        return simulators(arrows, colours, budget)

    return partial(bisimilar, budget=budget), simulating


def reduced_cubes(graph: LabelledGraph[Cube], budget: Budget) -> LabelledGraph[Cube]:
    """An equivalent graph with cubes; labels become disjoint if one more literal is enough."""

    def merge(graph: LabelledGraph[Cube]) -> LabelledGraph[Cube]:
        return merged_cubes(trimmed(graph), budget)

    def sharpen(graph: LabelledGraph[Cube]) -> LabelledGraph[Cube]:
        return _repeated(merge, sharpened(graph, budget))

    best = trimmed(graph)
    try:
        for step in (merge, sharpen):
            best = _repeated(step, best)
    except TranslationLimit:
        pass  # what was found so far is correct as well
    return best


def _repeated(
    step: Callable[[LabelledGraph[L]], LabelledGraph[L]], graph: LabelledGraph[L]
) -> LabelledGraph[L]:
    """Repeats a step as long as it changes the size, and returns the result."""
    while (smaller := step(graph)).size != graph.size:
        graph = smaller
    return smaller


def reduced_by_states(
    candidates: Sequence[LabelledGraph[LetterSet]], budget: Budget
) -> LabelledGraph[LetterSet]:
    """The smallest graph found from candidates with marks on states, the most promising first."""
    best = trimmed_by_states(candidates[0], False)
    with budget.spared(FIRST_STEPS) as most, budget.spared(OTHER_STEPS) as rest:
        first, others = _relations(most), _relations(rest)
        trials = [(first[0], candidates[0], False)]
        trials += [
            (first[1] if candidate is candidates[0] else others[1], candidate, transient_marked)
            for candidate in candidates
            for transient_marked in (False, True)
        ]
        tried: list[tuple[Relation, LabelledGraph[LetterSet]]] = []
        try:
            for relation, candidate, transient_marked in trials:
                start = trimmed_by_states(candidate, transient_marked)
                if (relation, start) in tried:
                    continue  # often no node is on no cycle
                tried.append((relation, start))
                merge = partial(_merged_by_states, relation=relation)
                found = _merged_and_trimmed(start, transient_marked, merge)
                best = min(best, found, key=lambda known: known.size)
        except TranslationLimit:
            pass  # what was found so far is correct as well
    return best


def reduced_cubes_by_states(graph: LabelledGraph[Cube], budget: Budget) -> LabelledGraph[Cube]:
    """An equivalent graph, from one with marks on states."""
    found = trimmed_by_states(graph, False)
    try:
        return _merged_and_trimmed(found, False, partial(merged_cubes, budget=budget))
    except TranslationLimit:
        return found


def _merged_and_trimmed(
    graph: LabelledGraph[L],
    transient_marked: bool,
    merge: Callable[[LabelledGraph[L]], LabelledGraph[L]],
) -> LabelledGraph[L]:
    while (smaller := trimmed_by_states(merge(graph), transient_marked)).size != graph.size:
        graph = smaller
    return graph


def _merged_by_states(
    graph: LabelledGraph[LetterSet], relation: Relation
) -> LabelledGraph[LetterSet]:
    """The quotient in both directions; backwards, accepting nodes replace only such nodes."""
    smaller = merged(graph, relation)
    accepting = [int(any(edge.marks for edge in leaving)) for leaving in smaller.edges]
    return merged_backwards(smaller, accepting, relation)
