"""The nodes of a product that are entered from some states of its automata."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Collection

from companion.planning.builtin.transition_system import Successors

Node = tuple[int, tuple[int, ...], int]
"""Facts, states of the automata, marks met on the way in."""


class EnteredNodes(dict[int, list[int]]):
    """By the facts that are reached, the nodes that are entered from some automaton states.

    Nodes are numbered as they are met.

    Args:
        moves: the joint moves of the automata on the label of some facts, with their marks.
        nodes: all that are known; new ones are added.
        number_of: their numbers.
        charging: actions of which each edge is kept, whatever it costs.
    """

    def __init__(
        self,
        moves: Callable[[int], list[tuple[tuple[int, ...], int]]],
        nodes: list[Node],
        number_of: dict[Node, int],
        charging: Collection[int],
    ) -> None:
        super().__init__()
        self._moves, self._nodes, self._number_of = moves, nodes, number_of
        self._charging = charging
        self._is_function = True  # so far each set of facts leads to one node

    def __missing__(self, facts: int) -> list[int]:
        numbers = []
        for following, marks in self._moves(facts):
            node = (facts, following, marks)
            number = self._number_of.setdefault(node, len(self._nodes))
            if number == len(self._nodes):
                self._nodes.append(node)
            numbers.append(number)
        self[facts] = numbers
        self._is_function &= len(numbers) == 1
        return numbers

    def edges(self, successors: Successors) -> Successors:
        """The nodes after a node, the cheapest edge to each."""
        entered = list(map(self.__getitem__, successors.states))
        ends = list(itertools.chain.from_iterable(entered))
        if self._is_function and len(set(ends)) == len(ends):
            return Successors(ends, successors.actions, successors.costs)
        cheapest: dict[int, tuple[int, int]] = {}
        charging: list[tuple[int, tuple[int, int]]] = []
        each = zip(entered, successors.actions, successors.costs, strict=True)
        for numbers, action, cost_ms in each:
            for number in numbers:
                if action in self._charging:
                    charging.append((number, (cost_ms, action)))
                    continue
                known = cheapest.get(number)
                if known is None or cost_ms < known[0]:
                    cheapest[number] = (cost_ms, action)
        kept = sorted([*cheapest.items(), *charging], key=_by_action)
        return Successors(
            [number for number, _ in kept],
            [action for _, (_, action) in kept],
            [cost_ms for _, (cost_ms, _) in kept],
        )


def _by_action(edge: tuple[int, tuple[int, int]]) -> int:
    return edge[1][1]
