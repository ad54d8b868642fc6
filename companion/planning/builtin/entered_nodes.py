"""Makes the nodes of a product that edges enter from certain states of its automata."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence

from companion.planning.builtin.transition_system import Successors
from companion.planning.domain import WAIT, duration_ms
from companion.planning.lasso import Problem

Node = tuple[int, tuple[int, ...], int]
"""Facts, states of the automata, and the marks met on the way in."""

Takes = tuple[int, int] | None
"""What an action takes besides its cost, where that matters: time and energy. None: it charges."""
_Edge = tuple[int, int, Takes]
"""An edge: its action, its cost, and what else it takes."""
_NOTHING: Takes = 0, 0


class EnteredNodes(dict[int, list[int]]):
    """For each set of facts reached, the nodes entered from certain automaton states.

    Nodes are numbered in the order of discovery.

    Args:
        moves: the joint moves of the automata on the label of some facts, with their marks.
        nodes: all known nodes; new ones are added.
        number_of: the numbers of these nodes.
        takes: by action; empty if only costs matter.
    """

    def __init__(
        self,
        moves: Callable[[int], list[tuple[tuple[int, ...], int]]],
        nodes: list[Node],
        number_of: dict[Node, int],
        takes: Sequence[Takes],
    ) -> None:
        super().__init__()
        self._moves, self._nodes, self._number_of = moves, nodes, number_of
        self._takes = takes
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
        """The nodes after a node, with the cheapest edge to each.

        More expensive edges are kept if they charge, or take less time or energy where that
        matters.
        """
        entered = list(map(self.__getitem__, successors.states))
        ends = list(itertools.chain.from_iterable(entered))
        if self._is_function and len(set(ends)) == len(ends):
            return Successors(ends, successors.actions, successors.costs)
        best: dict[int, list[_Edge]] = {}
        each = zip(entered, successors.actions, successors.costs, strict=True)
        for numbers, action, cost_ms in each:
            edge = action, cost_ms, self._takes[action] if self._takes else _NOTHING
            for number in numbers:
                known = best.get(number, ())
                if not any(_is_as_good(other, edge) for other in known):
                    best[number] = [
                        edge,
                        *(other for other in known if not _is_as_good(edge, other)),
                    ]
        kept = sorted((action, ms, end) for end, edges in best.items() for action, ms, _ in edges)
        return Successors(
            [end for _, _, end in kept],
            [action for action, _, _ in kept],
            [cost_ms for _, cost_ms, _ in kept],
        )


def _is_as_good(one: _Edge, other: _Edge) -> bool:
    """Whether an edge costs no more, and takes no more, than another one."""
    return one[1] <= other[1] and is_no_less(other[2], one[2])


def is_no_less(one: Takes, other: Takes) -> bool:
    """Whether an action takes no less than another one; a charge cannot be compared.

    >>> is_no_less((0, 3), (0, 2)), is_no_less(None, (0, 2))
    (True, False)
    """
    return one is not None and other is not None and one[0] >= other[0] and one[1] >= other[1]


def takes_of(problem: Problem) -> list[Takes]:
    """What each action of a problem takes besides its cost; empty if only costs matter."""
    energy, has_clocks = problem.energy, bool(problem.clocks_ms)
    if energy is None and not has_clocks:
        return []
    rest = 0 if energy is None else energy.rest
    return [
        None
        if energy is not None and action.charger is not None
        else (has_clocks * duration_ms(action), rest if action is WAIT else action.drain)
        for action in problem.actions
    ]
