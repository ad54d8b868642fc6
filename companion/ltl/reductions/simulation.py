"""Simulation: finds which nodes can do everything that another node does.

A node *simulates* another if it can match every edge of it, letter by letter: by an edge that reads
the letter, has at least the same marks, and leads to a node that simulates the target. The same
relation is found backwards if it is given the edges into each node.

Cubes are compared edge by edge, with the same algorithm: `CubeOrder` turns them into sets.

Source: Etessami and Holzmann, Optimizing Büchi automata, CONCUR 2000; Henzinger, Henzinger and
Kopke, Computing simulations on finite and infinite graphs, FOCS 1995, for splitting blocks.
"""

from __future__ import annotations

from collections.abc import Hashable, Sequence

from companion.ltl.bitsets import indices
from companion.ltl.budget import Budget
from companion.ltl.graph import LabelledEdge, LabelledGraph, Marks, Nodes
from companion.ltl.labels import Cube, CubeOrder, LetterSet
from companion.ltl.reductions.bisimulation import Arrows, Signature, signature


def simulators(arrows: Arrows, colours: Sequence[int], budget: Budget) -> list[Nodes]:
    """For each node the nodes that simulate it; the greatest such relation.

    Nodes that simulate each other, as far as known, are a block. Blocks are split until none
    changes.

    Args:
        colours: bits that a node must have to simulate another one with them.

    Raises:
        TranslationLimit: the budget is spent.
    """
    edges = [edge for leaving in arrows for edge in leaving]
    width = max((edge.label.bit_length() for edge in edges), default=0)
    kinds = sorted(set(colours))
    block = [kinds.index(colour) for colour in colours]
    above = [sum(1 << i for i, b in enumerate(kinds) if a & ~b == 0) for a in kinds]
    is_stable = False
    while not is_stable:
        budget.spend(3 * (len(edges) + len(arrows)), width)
        finer, block = _refined(arrows, block, above, width, budget)
        is_stable = len(finer) == len(above) and _pairs(finer) == _pairs(above)
        above = finer
    nodes_of = [0] * len(above)
    for node, number in enumerate(block):
        nodes_of[number] |= 1 << node
    union = [sum(nodes_of[other] for other in indices(better)) for better in above]
    return [union[number] for number in block]


def _pairs(above: list[Nodes]) -> int:
    return sum(map(int.bit_count, above))


def _refined(
    arrows: Arrows, block: list[int], above: list[Nodes], width: int, budget: Budget
) -> tuple[list[Nodes], list[int]]:
    """Blocks, and the simulators of each block, after one more step."""
    number_of: dict[Hashable, int] = {}
    signatures: list[Signature] = []
    parts_of: list[list[int]] = [[] for _ in above]
    origin: list[int] = []
    part = []
    for node, leaving in enumerate(arrows):
        signed = signature(leaving, block)
        key = (block[node], frozenset(signed.items()))
        if key not in number_of:
            number_of[key] = len(signatures)
            parts_of[block[node]].append(len(signatures))
            signatures.append(signed)
            origin.append(block[node])
        part.append(number_of[key])
    matching = [_MatchedLetters(signed, above, width, budget) for signed in signatures]
    better = []
    for number, signed in enumerate(signatures):
        able = 1 << number
        for old in indices(above[origin[number]]):
            budget.spend(3 * len(parts_of[old]), len(arrows))
            for other in parts_of[old]:
                if other != number and matching[other].include(signed):
                    able |= 1 << other
        better.append(able)
    leader = leaders(better)
    place = {number: i for i, number in enumerate(sorted(set(leader)))}
    finer = [sum(1 << place[i] for i in indices(better[n]) if i in place) for n in place]
    return finer, [place[leader[number]] for number in part]


class _MatchedLetters(dict[tuple[Marks, int], LetterSet]):
    """The letters of all edges of a node that are at least as good as given marks and block."""

    def __init__(
        self, signed: Signature, above: Sequence[Nodes], width: int, budget: Budget
    ) -> None:
        self._signature = signed
        self._above = above
        self._width = width
        self._budget = budget

    def __missing__(self, kind: tuple[Marks, int]) -> LetterSet:
        marks, block = kind
        better = self._above[block]
        self._budget.spend(len(self._signature), self._width)
        found = LetterSet(0)
        for (more, other), letters in self._signature.items():
            if marks & ~more == 0 and better >> other & 1:
                found |= letters
        self[kind] = found
        return found

    def include(self, signed: Signature) -> bool:
        """Whether each letter of a signature has an edge that is at least as good."""
        for kind, letters in signed.items():  # all() takes twice as long
            if letters & ~self[kind]:
                return False
        return True


def leaders(above: Sequence[Nodes]) -> list[int]:
    """For each node, the first of the nodes that it simulates and that simulate it.

    >>> leaders([0b011, 0b011, 0b111])
    [0, 0, 2]
    """
    return [
        next(i for i in indices(better) if above[i] >> node & 1)
        for node, better in enumerate(above)
    ]


def cube_simulators(graph: LabelledGraph[Cube], budget: Budget) -> list[Nodes]:
    """For each node the nodes that simulate it, where one edge has to be matched by one edge.

    Raises:
        TranslationLimit: the budget is spent.
    """
    return simulators(ordered(graph, budget)[1], [0] * len(graph.edges), budget)


def ordered(graph: LabelledGraph[Cube], budget: Budget) -> tuple[CubeOrder, Arrows]:
    """The order of the cubes of a graph, and its edges with sets of cubes as labels.

    Raises:
        TranslationLimit: the budget is spent.
    """
    cubes = {edge.label for leaving in graph.edges for edge in leaving}
    literals = sum(int(cube).bit_count() for cube in cubes)
    budget.spend(2 * literals, len(cubes))
    budget.keep(len(cubes), len(cubes))
    order = CubeOrder(cubes)
    arrows = [
        [LabelledEdge(order.letters(cube), marks, target) for cube, marks, target in leaving]
        for leaving in graph.edges
    ]
    return order, arrows
