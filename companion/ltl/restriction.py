"""Restriction: reduces an automaton for propositions that keep their value.

A plan assumes that events keep their value and beliefs hold, and many facts are changed by no
action. So letters differ in few propositions, and the automaton of a conjunct often shrinks to a
state or two: `G (F at(A) | targetFound)` is `G F at(A)` until a target is found, and `true`
afterwards. The formula is not translated again; its automaton is cut down and reduced.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache

from companion.ltl.automaton import BuchiAutomaton, statistics
from companion.ltl.budget import Budget, TranslationLimit
from companion.ltl.components import strong_components
from companion.ltl.graph import LabelledEdge, LabelledGraph, Marks, Nodes, automaton_of
from companion.ltl.labels import Alphabet, Cube, joined
from companion.ltl.reductions.quotient import merged_cubes_and_simulators
from companion.ltl.reductions.trimming import trimmed

MAX_STEPS = 12_000_000
"""Budget for the reduction of one automaton: about a second."""


@dataclass(frozen=True)
class Restriction:
    """A reduced automaton, and which of its states replaces each state of the whole automaton.

    Attributes:
        automaton: reads the propositions that are left; has no initial states of its own.
        state_of: for each state of the whole automaton its state here; no entry if nothing is
            accepted from it any more.
        simulators: for each state here, the states (as bits) that accept everything that it
            accepts.
    """

    automaton: BuchiAutomaton
    state_of: Mapping[int, int]
    simulators: tuple[int, ...]

    def states(self, whole: frozenset[int]) -> list[int]:
        """The states here for a set of states of the whole automaton; the first of equal ones.

        A state that another one simulates is kept: its runs may close a loop sooner.
        """
        found = sorted({self.state_of[state] for state in whole if state in self.state_of})
        return [s for s in found if not any(self._are_equal(s, t) for t in found if t < s)]

    def _are_equal(self, one: int, other: int) -> bool:
        return bool(self.simulators[one] >> other & 1 and self.simulators[other] >> one & 1)

    @cached_property
    def everything(self) -> frozenset[int]:
        """The states from which every word is accepted: they read all letters with every mark."""
        return frozenset(
            state
            for state, leaving in enumerate(self.automaton.outgoing)
            if len(leaving) == 1
            and leaving[0].target == state
            and not (leaving[0].label.positive or leaving[0].label.negative)
            and len(leaving[0].marks) == self.automaton.marks
        )

    @cached_property
    def can_return(self) -> bool:
        """Whether a run can return to a state that it has left."""
        successors = [{t.target for t in leaving} for leaving in self.automaton.outgoing]
        return any(len(component) > 1 for component in strong_components(successors))

    @cached_property
    def one_shot_goals(self) -> frozenset[int]:
        """The states that wait for one letter of some kind, whatever else they read, e.g. `F p`."""
        if not statistics(replace(self.automaton, initial=frozenset({0}))).is_complete:
            return frozenset()
        found = set()
        for state, leaving in enumerate(self.automaton.outgoing):
            ends = {t.target for t in leaving} - {state}
            waiting = [t.marks for t in leaving if t.target == state]
            met = frozenset().union(*waiting)
            if waiting and ends and ends <= self.everything and len(met) < self.automaton.marks:
                found.add(state)
        return frozenset(found)


def restricted(automaton: BuchiAutomaton, constants: Mapping[str, bool]) -> Restriction:
    """An automaton for words in which the constants have these values at every position.

    >>> from companion.ltl.parser import parse
    >>> from companion.ltl.translate import translate
    >>> search = translate(parse("G (F a | found)"))
    >>> patrol = restricted(search, {"found": False}).automaton
    >>> patrol.states, patrol.propositions
    (1, ('a',))
    """
    names = [name for name in automaton.propositions if name not in constants]
    alphabet = Alphabet(names)
    rooted = _with_root(automaton, constants, alphabet)
    graph, simulators = _reduced(tuple(map(tuple, rooted.edges)), rooted.marks)
    first_tag = 2 * len(names)
    state_of = {
        (int(edge.label).bit_length() - 1 - first_tag) // 2: edge.target - 1
        for edge in graph.edges[0]
    }
    inner = [
        [LabelledEdge(cube, marks, target - 1) for cube, marks, target in leaving]
        for leaving in graph.edges[1:]
    ]
    left = LabelledGraph(inner, graph.marks)
    return Restriction(
        automaton_of(left, alphabet, automaton.name, initial=frozenset()),
        state_of,
        tuple(above >> 1 for above in simulators[1:]),
    )


@lru_cache(maxsize=256)
def _reduced(
    edges: tuple[tuple[LabelledEdge[Cube], ...], ...], marks: int
) -> tuple[LabelledGraph[Cube], list[Nodes]]:
    """A reduced graph, and the simulators of each node that is left.

    Results are cached: conjuncts of one kind, such as those of a patrol, differ only in their
    names. A graph whose reduction would take too many steps stays as it is.
    """
    graph = trimmed(LabelledGraph([list(leaving) for leaving in edges], marks))
    try:
        return merged_cubes_and_simulators(graph, Budget(MAX_STEPS))
    except TranslationLimit:
        return graph, [1 << node for node in range(len(graph.edges))]


def _with_root(
    automaton: BuchiAutomaton, constants: Mapping[str, bool], alphabet: Alphabet
) -> LabelledGraph[Cube]:
    """The states as nodes from 1 on, with the labels that are possible, preceded by a root.

    From the root an edge leads to each state, with a label of its own. So all states are reachable,
    and none of these edges covers another one.
    """
    first_tag = 2 * len(alphabet.names)
    root = [
        LabelledEdge(Cube(1 << first_tag + 2 * state), 0, state + 1)
        for state in range(automaton.states)
    ]
    holding = {name for name, holds in constants.items() if holds}
    failing = constants.keys() - holding
    edges = [root]
    for leaving in automaton.outgoing:
        cubes: dict[tuple[Marks, int], set[Cube]] = defaultdict(set)
        for t in leaving:
            if t.label.positive.isdisjoint(failing) and t.label.negative.isdisjoint(holding):
                marks = sum(1 << mark for mark in t.marks)
                cubes[marks, t.target + 1].add(alphabet.cube(t.label))
        edges.append([LabelledEdge(cube, *rest) for rest in cubes for cube in joined(cubes[rest])])
    return LabelledGraph(edges, automaton.marks)
