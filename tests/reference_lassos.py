"""The best lasso over all lassos, by the semantics of LTL alone: no automaton, no product.

The truth of a formula at a position depends on the letter there and on the truth of its parts at
the next position. So a finite word is a function: from the truths at the position after it to
those at its first position. There are finitely many such functions, which makes the search
exhaustive: every closed walk of the transition system is looked at, up to walks through the same
facts whose words are the same function, of which the cheapest is kept.

Of a loop v the function says what holds at the start of v v v ...: part after part, operands first.
If the function leaves the part what it is, nothing in a lap decides it; then an Until does not
hold, as its event never comes, and a Release does.

Source: Wolper, Vardi and Sistla, Reasoning about infinite computation paths, FOCS 1983, for truths
as states; Perrin and Pin, Infinite Words, 2004, for finite words as functions.
"""

from __future__ import annotations

import heapq
import itertools
import operator
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property, reduce

import numpy as np
from numpy.typing import NDArray

from companion.ltl.formula import Formula, Operator, conjoin, subformulas
from companion.planning.lasso import Letter, Problem

Function = NDArray[np.intp]
"""From truths at the position after a word to truths at its first position, as bits of ints."""

LEAST = (Operator.EVENTUALLY, Operator.UNTIL)
GREATEST = (Operator.ALWAYS, Operator.RELEASE, Operator.WEAK_UNTIL)
MAX_PARTS = 11
"""Parts of a formula whose truths are bits: a function has 2^11 values."""
MANY_WALKS = 500_000


class TooLarge(Exception):
    """The problem is too large to be searched by definition."""


class Truths:
    """The truths of the parts of a formula that reach over positions, as bits of an int."""

    def __init__(self, formula: Formula) -> None:
        self._formula = formula
        self._nodes = list(subformulas(formula))
        after_next = {n.operands[0] for n in self._nodes if n.operator is Operator.NEXT}
        self._parts = [n for n in self._nodes if n.operator in LEAST + GREATEST or n in after_next]
        if len(self._parts) > MAX_PARTS:
            raise TooLarge(f"{len(self._parts)} parts")
        self._atoms = frozenset(n.atom for n in self._nodes if n.operator is Operator.ATOM)
        self._every = np.arange(1 << len(self._parts))
        self._at: dict[Letter, dict[Formula, NDArray[np.bool_]]] = {}

    @property
    def identity(self) -> Function:
        """The function of the empty word."""
        return self._every

    def function(self, letter: Letter) -> Function:
        """The function of a word of one letter."""
        held = self._held(letter)
        found = np.zeros_like(self._every)
        for bit, part in enumerate(self._parts):
            found |= held[part].astype(np.intp) << bit
        return found

    def holds(self, letter: Letter) -> NDArray[np.bool_]:
        """Whether the formula holds at a letter, for all truths at the next position."""
        return self._held(letter)[self._formula]

    def repeated(self, lap: Function) -> int:
        """The truths at the start of a word that repeats one for ever, given its function."""
        truths = 0
        for bit, part in enumerate(self._parts):
            without, having = (int(lap[truths | own << bit]) >> bit & 1 for own in (0, 1))
            is_open = (without, having) == (0, 1)
            truths |= (part.operator in GREATEST if is_open else without) << bit
        return truths

    def _held(self, letter: Letter) -> dict[Formula, NDArray[np.bool_]]:
        letter = letter & self._atoms
        if letter not in self._at:
            held: dict[Formula, NDArray[np.bool_]] = {}
            after = {p: (self._every >> bit & 1).astype(bool) for bit, p in enumerate(self._parts)}
            for node in self._nodes:
                held[node] = self._node(node, letter, [held[o] for o in node.operands], after)
            self._at[letter] = held
        return self._at[letter]

    def _node(
        self,
        node: Formula,
        letter: Letter,
        held: list[NDArray[np.bool_]],
        after: dict[Formula, NDArray[np.bool_]],
    ) -> NDArray[np.bool_]:
        """The truth of a node by those of its operands here, and its own at the next position."""
        match node.operator:
            case Operator.TRUE | Operator.FALSE | Operator.ATOM:
                value = node.operator is Operator.TRUE or node.atom in letter
                return np.full(len(self._every), value)
            case Operator.NOT:
                return ~held[0]
            case Operator.NEXT:
                return after[node.operands[0]]
            case Operator.EVENTUALLY:
                return held[0] | after[node]
            case Operator.ALWAYS:
                return held[0] & after[node]
            case Operator.UNTIL | Operator.WEAK_UNTIL:
                return held[1] | held[0] & after[node]
            case Operator.RELEASE:
                return held[1] & (held[0] | after[node])
            case Operator.IMPLIES:
                return ~held[0] | held[1]
            case Operator.IFF:
                return ~(held[0] ^ held[1])
            case Operator.AND:
                return reduce(operator.and_, held)
            case Operator.OR:
                return reduce(operator.or_, held)
        raise AssertionError(node.operator)


@dataclass
class Walk:
    """A walk of the transition system: where it began and ends, its cost, its word's function."""

    start: Letter
    end: Letter
    cost_ms: int
    function: Function


class Reference:
    """The best lassos of a problem after a history of letters that every conjunct has read.

    Args:
        max_walks: different walks after which it is given up.

    Raises:
        TooLarge: there are more, or the formulas have too many parts.
    """

    def __init__(self, asked: Problem, letters: list[Letter], max_walks: int = 30_000) -> None:
        self._asked, self._max_walks = asked, max_walks
        self._truths = Truths(conjoin(*(c.formula for c in asked.conjuncts)))
        first, *rest = letters
        read = self._truths.identity
        for letter in rest:
            read = read[self._truths.function(letter)]
        self._is_right = self._truths.holds(first)[read]
        self._steps: dict[Letter, list[tuple[Letter, int, Function]]] = {}

    def best_lap_and_prefix(self) -> tuple[int, int] | None:
        """The shortest lap of all lassos, and the shortest prefix of those with such a lap."""
        best: tuple[int, int] | None = None
        for walk in self._loops():
            if best is not None and walk.cost_ms > best[0]:
                break
            prefix_ms = self._prefix_ms(walk)
            if prefix_ms is not None:
                best = min(best or (walk.cost_ms, prefix_ms), (walk.cost_ms, prefix_ms))
        return best

    def best_sum(self) -> int | None:
        """The least cost of prefix and lap together."""
        best: int | None = None
        for walk in self._loops():
            if best is not None and walk.cost_ms >= best:
                break
            prefix_ms = self._prefix_ms(walk)
            if prefix_ms is not None:
                best = min(best or prefix_ms + walk.cost_ms, prefix_ms + walk.cost_ms)
        return best

    @cached_property
    def _prefixes(self) -> dict[Letter, list[int | None]]:
        """By facts and by the truths that follow: the shortest prefix with which the task holds."""
        count = len(self._truths.identity)
        found: dict[Letter, list[int | None]] = {}
        for walk in self._walks([self._asked.facts]):
            row = found.setdefault(walk.end, [None] * count)
            for truths in np.flatnonzero(self._is_right[walk.function]).tolist():
                if row[truths] is None:  # walks come in the order of their costs
                    row[truths] = walk.cost_ms
        return found

    def _prefix_ms(self, loop: Walk) -> int | None:
        return self._prefixes[loop.end][self._truths.repeated(loop.function)]

    def _loops(self) -> Iterator[Walk]:
        """Closed walks, cheapest first."""
        for walk in self._walks(list(self._prefixes)):
            if walk.cost_ms and walk.start == walk.end:
                yield walk

    def _walks(self, starts: list[Letter]) -> Iterator[Walk]:
        """Walks from some facts, cheapest first; of equal function and ends only the cheapest."""
        ticket = itertools.count()
        identity = self._truths.identity
        queue = [(0, next(ticket), Walk(start, start, 0, identity)) for start in starts]
        seen: set[tuple[Letter, Letter, bytes, bool]] = set()
        while queue:
            cost_ms, _, walk = heapq.heappop(queue)
            key = (walk.start, walk.end, walk.function.tobytes(), cost_ms > 0)
            if key in seen:
                continue
            seen.add(key)
            if len(seen) > self._max_walks:
                raise TooLarge(f"{self._max_walks} walks")
            yield walk
            for end, step_ms, function in self._leaving(walk.end):
                later = Walk(walk.start, end, cost_ms + step_ms, walk.function[function])
                heapq.heappush(queue, (later.cost_ms, next(ticket), later))

    def _leaving(self, facts: Letter) -> list[tuple[Letter, int, Function]]:
        if facts not in self._steps:
            able = (a for a in self._asked.actions if a.is_applicable(facts))
            ends = ((a.apply(facts), a.cost_ms) for a in able)
            self._steps[facts] = [(end, ms, self._truths.function(end)) for end, ms in ends]
        return self._steps[facts]


def best_lap_and_prefix(
    asked: Problem, letters: list[Letter] | None = None
) -> tuple[int, int] | None:
    """The shortest lap, and the shortest prefix to one; without a history, from the beginning."""
    return Reference(asked, letters or [asked.facts], MANY_WALKS).best_lap_and_prefix()


def best_sum(asked: Problem, letters: list[Letter] | None = None) -> int | None:
    """The least cost of prefix and lap together; without a history, from the beginning."""
    return Reference(asked, letters or [asked.facts], MANY_WALKS).best_sum()
