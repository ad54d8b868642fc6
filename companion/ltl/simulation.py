"""Which node of an automaton does all that another one does? Relations between nodes.

The labels are sets of letters (`letters.py`). A node *simulates* another if it can match every
edge of it, letter by letter: by an edge that reads the letter, has at least the same marks, and
leads to a node that simulates the target. Given the edges into each node instead of those that
leave it, the same relations are found backwards.

Source: Etessami and Holzmann, Optimizing Büchi automata, CONCUR 2000; Henzinger, Henzinger and
Kopke, Computing simulations on finite and infinite graphs, FOCS 1995, for splitting blocks.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Hashable, Iterable, Sequence

from companion.ltl.budget import Budget, TranslationLimit
from companion.ltl.reduction import Edge, indices

MAX_SIMULATED = 400
"""States up to which it is tried to find out which simulates which."""

Signature = dict[tuple[int, int], int]
"""The letters of the edges with certain marks to (or from) a certain block of nodes."""


def equals(arrows: Sequence[Sequence[Edge]], colours: Sequence[int], budget: Budget) -> list[int]:
    """For each node the set (bits) of the nodes that have its colour and do the same in all steps.

    Args:
        arrows: edges that leave each node, or those that enter it with their sources as targets.
    """
    block, count = list(colours), len(set(colours))
    size = sum(map(len, arrows))
    while True:
        budget.spend(3 * (size + len(arrows)))
        number_of: dict[Hashable, int] = {}
        block = [
            number_of.setdefault(
                (block[node], frozenset(signature_of(leaving, block).items())), len(number_of)
            )
            for node, leaving in enumerate(arrows)
        ]
        if len(number_of) == count:
            break
        count = len(number_of)
    nodes_of = [0] * count
    for node, number in enumerate(block):
        nodes_of[number] |= 1 << node
    return [nodes_of[number] for number in block]


def simulators(
    arrows: Sequence[Sequence[Edge]], colours: Sequence[int], budget: Budget
) -> list[int]:
    """For each node the set (bits) of the nodes that simulate it; the greatest such relation.

    Nodes that simulate each other, as far as is known, are a block; blocks are split until none
    of them changes.

    Args:
        arrows: edges that leave each node, or those that enter it with their sources as targets.
        colours: bits that a node must have to simulate one that has them.
    """
    if len(arrows) > MAX_SIMULATED:
        raise TranslationLimit(f"{MAX_SIMULATED} states to compare")
    kinds = sorted(set(colours))
    block = [kinds.index(colour) for colour in colours]
    above = [sum(1 << i for i, b in enumerate(kinds) if a & ~b == 0) for a in kinds]
    is_stable = False
    while not is_stable:
        finer, block = _refined(arrows, block, above, budget)
        is_stable = len(finer) == len(above) and _pairs(finer) == _pairs(above)
        above = finer
    nodes_of = [0] * len(above)
    for node, number in enumerate(block):
        nodes_of[number] |= 1 << node
    union = [sum(nodes_of[other] for other in indices(better)) for better in above]
    return [union[number] for number in block]


def _pairs(above: list[int]) -> int:
    return sum(map(int.bit_count, above))


def _refined(
    arrows: Sequence[Sequence[Edge]], block: list[int], above: list[int], budget: Budget
) -> tuple[list[int], list[int]]:
    """Blocks, and those that simulate each of them, one step longer."""
    number_of: dict[Hashable, int] = {}
    signatures: list[Signature] = []
    parts_of: list[list[int]] = [[] for _ in above]
    origin: list[int] = []
    part = []
    for node, leaving in enumerate(arrows):
        signature = signature_of(leaving, block)
        key = (block[node], frozenset(signature.items()))
        if key not in number_of:
            number_of[key] = len(signatures)
            parts_of[block[node]].append(len(signatures))
            signatures.append(signature)
            origin.append(block[node])
        part.append(number_of[key])
    readers = [_Reader(signature, above, budget) for signature in signatures]
    better = []
    for number, signature in enumerate(signatures):
        able = 1 << number
        for old in indices(above[origin[number]]):
            budget.spend(3 * len(parts_of[old]))
            able |= sum(1 << n for n in parts_of[old] if n != number and readers[n].does(signature))
        better.append(able)
    leader = leaders(better)
    place = {number: i for i, number in enumerate(sorted(set(leader)))}
    finer = [sum(1 << place[i] for i in indices(better[n]) if i in place) for n in place]
    return finer, [place[leader[number]] for number in part]


class _Reader(dict[tuple[int, int], int]):
    """For marks and a block the letters of all edges of a node that are at least as good."""

    def __init__(self, signature: Signature, above: Sequence[int], budget: Budget) -> None:
        super().__init__()
        self._signature = signature
        self._above = above
        self._budget = budget

    def __missing__(self, kind: tuple[int, int]) -> int:
        marks, block = kind
        better = self._above[block]
        self._budget.spend(len(self._signature))
        found = 0
        for (more, other), letters in self._signature.items():
            if marks & ~more == 0 and better >> other & 1:
                found |= letters
        self[kind] = found
        return found

    def does(self, signature: Signature) -> bool:
        """Whether each letter of a signature has an edge that is at least as good."""
        for kind, letters in signature.items():  # all() takes twice as long
            if letters & ~self[kind]:
                return False
        return True


def signature_of(leaving: Iterable[Edge], block: Sequence[int]) -> Signature:
    """The letters of edges with the same marks to the same block."""
    signature: Signature = defaultdict(int)
    for label, marks, target in leaving:
        signature[marks, block[target]] |= label
    return dict(signature)


def leaders(above: Sequence[int]) -> list[int]:
    """For each node the first of those that it simulates and that simulate it."""
    return [
        next(i for i in indices(better) if above[i] >> node & 1)
        for node, better in enumerate(above)
    ]
