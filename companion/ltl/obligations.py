"""Has the language a weak deterministic automaton? Then the smallest of them is unique.

Most missions are *obligations*: what a run is in for in the end depends only on the component in
which it stays. Their automata come from the powerset construction: a component accepts if one of
its cycles does, since all of them agree. If the language is no obligation the result accepts
something else; so it is compared with an automaton of the language and one of its complement.

Labels are sets of letters (`letters.py`). Source: Löding, Efficient minimization of deterministic
weak omega-automata, IPL 2001; Dax, Eisinger and Klaedtke, Mechanizing the powerset construction
for restricted classes of omega-automata, ATVA 2007.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Hashable, Sequence
from dataclasses import dataclass
from functools import reduce
from operator import or_

from companion.ltl.automaton import strong_components
from companion.ltl.budget import Budget
from companion.ltl.reduction import Edge, Graph, indices, reachable

POWERSET_MARGIN = 8
"""How many times larger than an automaton its powerset may be."""

Steps = list[dict[int, int]]
"""For each state of a complete deterministic automaton the letters that lead to each target."""


@dataclass(frozen=True, slots=True)
class _Weak:
    """A complete deterministic automaton; a run accepts if it stays among accepting states."""

    steps: Steps
    accepting: list[bool]


def weak_deterministic(
    graph: Graph, every: int, complement: Callable[[], Graph], budget: Budget
) -> Graph | None:
    """The smallest weak deterministic automaton of a language; its dead state is left out.

    Args:
        graph: accepts the language.
        every: the set of all letters.
        complement: makes a graph that accepts all other words; called if it is needed.

    Returns:
        With one mark, on all edges of accepting states; None if the language is no obligation.

    Raises:
        TranslationLimit: the budget is spent.
    """
    determined = _powerset(graph, every, budget)
    weak = determined and _weak(graph, *determined)
    if weak is None or _meets(weak, graph, False, budget):
        return None
    return None if _meets(weak, complement(), True, budget) else _minimal(weak)


def _powerset(graph: Graph, every: int, budget: Budget) -> tuple[Steps, list[int]] | None:
    """The subset construction, and the set of nodes of each of its states; None if too many."""
    number_of = {1: 0}
    pending = [1]
    steps: Steps = []
    for nodes in pending:  # grows while it is read
        cells = {0: every}  # the nodes that some letters lead to
        for node in indices(nodes):
            for label, _, target in graph.edges[node]:
                budget.spend(len(cells), every.bit_length())
                split: dict[int, int] = defaultdict(int)
                for reached, letters in cells.items():
                    if letters & label:
                        split[reached | 1 << target] |= letters & label
                    if letters & ~label:
                        split[reached] |= letters & ~label
                cells = split
        for reached in cells:
            if reached not in number_of:
                number_of[reached] = len(pending)
                pending.append(reached)
        if len(pending) > POWERSET_MARGIN * len(graph.edges):
            return None
        steps.append({number_of[reached]: letters for reached, letters in cells.items()})
    return steps, pending


def _weak(graph: Graph, steps: Steps, nodes_of: Sequence[int]) -> _Weak | None:
    """The powerset with its accepting states; None if two cycles of a component disagree.

    States that no cycle passes get the colour that lets most states be equal: a component is
    even if it accepts, and odd otherwise, as high as what it leads to allows.
    """
    component_of: dict[int, int] = {}
    colours: list[int] = []
    top = 2 * len(steps)
    for component in strong_components(steps):
        component_of.update(dict.fromkeys(component, len(colours)))
        inside = set(component)
        after = [colours[component_of[t]] for n in component for t in steps[n] if t not in inside]
        colour = min(after, default=top + 1)
        if len(component) > 1 or component[0] in steps[component[0]]:
            verdicts = {
                _accepts(graph, nodes_of[component[0]], _cycle(steps, component, letter_of))
                for letter_of in (_lowest, _highest)
            }
            if len(verdicts) > 1:
                return None
            colour -= colour % 2 == verdicts.pop()
        colours.append(colour)
    return _Weak(steps, [colours[component_of[n]] % 2 == 0 for n in range(len(steps))])


def _lowest(letters: int) -> int:
    return letters & -letters


def _highest(letters: int) -> int:
    return 1 << letters.bit_length() - 1


def _cycle(steps: Steps, component: list[int], letter_of: Callable[[int], int]) -> list[int]:
    """Letters (each a set of one) along a shortest cycle through the first of some states."""
    inside = set(component)
    came_from: dict[int, tuple[int, int]] = {}
    pending = [component[0]]
    for state in pending:  # grows while it is read
        for target, letters in steps[state].items():
            if target in inside and target not in came_from:
                came_from[target] = (state, letter_of(letters))
                pending.append(target)
    state, letter = came_from[component[0]]
    word = [letter]
    while state != component[0]:
        state, letter = came_from[state]
        word.append(letter)
    return word[::-1]


def _accepts(graph: Graph, nodes: int, loop: Sequence[int]) -> bool:
    """Whether a word that repeats for ever is accepted from one of some nodes."""
    number_of = {(node, 0): i for i, node in enumerate(indices(nodes))}
    pending = list(number_of)
    edges: list[list[Edge]] = []
    for node, place in pending:  # grows while it is read
        after = (place + 1) % len(loop)
        edges.append([])
        for label, marks, target in graph.edges[node]:
            if label & loop[place]:
                number = number_of.setdefault((target, after), len(pending))
                if number == len(pending):
                    pending.append((target, after))
                edges[-1].append(Edge(label, marks, number))
    return _has_accepting_cycle(edges, (1 << graph.marks) - 1, [True] * len(edges))


def _meets(weak: _Weak, graph: Graph, accepting: bool, budget: Budget) -> bool:
    """Whether a word of the graph leads the weak automaton to accept, or to reject."""
    number_of = {(0, 0): 0}
    pending = [(0, 0)]
    edges: list[list[Edge]] = []
    for state, node in pending:  # grows while it is read
        edges.append([])
        budget.spend(len(graph.edges[node]) * len(weak.steps[state]))
        for label, marks, target in graph.edges[node]:
            for after, letters in weak.steps[state].items():
                if label & letters:
                    number = number_of.setdefault((after, target), len(pending))
                    if number == len(pending):
                        pending.append((after, target))
                    edges[-1].append(Edge(label, marks, number))
    is_wanted = [weak.accepting[state] is accepting for state, _ in pending]
    return _has_accepting_cycle(edges, (1 << graph.marks) - 1, is_wanted)


def _has_accepting_cycle(
    edges: Sequence[Sequence[Edge]], every_mark: int, is_wanted: Sequence[bool]
) -> bool:
    for component in strong_components([[e.target for e in leaving] for leaving in edges]):
        inside = set(component)
        marks = [e.marks for node in component for e in edges[node] if e.target in inside]
        if marks and is_wanted[component[0]] and reduce(or_, marks) == every_mark:
            return True
    return False


def _minimal(weak: _Weak) -> Graph:
    """States that accept the same words made one, as in finite automata (Moore)."""
    block = [int(accepts) for accepts in weak.accepting]
    count = 0
    while True:
        number_of: dict[Hashable, int] = {}
        finer = []
        for state, step in enumerate(weak.steps):
            letters_to: dict[int, int] = defaultdict(int)
            for target, letters in step.items():
                letters_to[block[target]] |= letters
            key = (block[state], frozenset(letters_to.items()))
            finer.append(number_of.setdefault(key, len(number_of)))
        block = finer
        if len(number_of) == count:
            break
        count = len(number_of)
    edges: list[list[Edge]] = [[] for _ in range(count)]
    for state, step in enumerate(weak.steps):
        if not edges[block[state]]:
            letters_to = defaultdict(int)
            for target, letters in step.items():
                letters_to[block[target]] |= letters
            edges[block[state]] = [
                Edge(letters, int(weak.accepting[state]), target)
                for target, letters in letters_to.items()
            ]
    return reachable(edges, 1, block[0])


def conjoined(one: Graph, other: Graph, budget: Budget) -> Graph:
    """Accepts the words that both graphs accept."""
    width = max((e.label.bit_length() for leaving in one.edges for e in leaving), default=0)
    number_of = {(0, 0): 0}
    pending = [(0, 0)]
    edges: list[list[Edge]] = []
    for first, second in pending:  # grows while it is read
        budget.spend(5 * len(one.edges[first]) * len(other.edges[second]), width)
        joint: dict[tuple[int, int], int] = defaultdict(int)
        for label, marks, target in one.edges[first]:
            for also, more, partner in other.edges[second]:
                if label & also:
                    number = number_of.setdefault((target, partner), len(pending))
                    if number == len(pending):
                        pending.append((target, partner))
                    joint[marks | more << one.marks, number] |= label & also
        budget.keep(len(joint), width)
        edges.append([Edge(letters, *kind) for kind, letters in joint.items()])
    return Graph(edges, one.marks + other.marks)
