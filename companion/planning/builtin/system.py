"""What do actions do to facts? The transition system of a problem, over bit masks.

Most facts never change in a plan: events keep their value, beliefs hold, and much of what a
mission can name is out of reach. What can change is found by relaxed reachability (actions
without their deletes, Bonet and Geffner 2001); all else is a constant. A state is the set of
the facts that hold among those that can change.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence
from typing import NamedTuple

from companion.planning.domain import Action, ConditionalEffect, Fact


class MaskedEffect(NamedTuple):
    """A conditional effect over bit masks."""

    requires: int
    forbids: int
    adds: int
    deletes: int


class Step(NamedTuple):
    """An action over bit masks; `action` is its place among the problem's actions."""

    action: int
    requires: int
    forbids: int
    adds: int
    deletes: int
    cost_ms: int
    conditional: tuple[MaskedEffect, ...]


class Move(NamedTuple):
    """What an action leads to from a state."""

    after: int
    action: int
    cost_ms: int


class Vocabulary:
    """Bits of facts, and actions over them.

    Args:
        actions: these are turned into bits once and kept; others are each time.
    """

    def __init__(self, actions: Sequence[Action]) -> None:
        self._bit: dict[Fact, int] = {}
        self._actions = actions  # keeps the identities below their own
        self._steps: dict[int, Step] = {}
        for index, action in enumerate(actions):
            self._steps[id(action)] = self._step(index, action)

    def mask(self, facts: Iterable[Fact]) -> int:
        """The bits of some facts."""
        bits = 0
        for fact in sorted(facts):  # sets have no order of their own
            bits |= self.bit(fact)
        return bits

    def bit(self, fact: Fact) -> int:
        """The bit of a fact."""
        bit = self._bit.get(fact)
        if bit is None:
            bit = self._bit[fact] = 1 << len(self._bit)
        return bit

    def steps(self, actions: Sequence[Action]) -> list[Step]:
        """The actions over bits, in their order."""
        known = self._steps
        return [
            step
            if (step := known.get(id(action))) is not None and step.action == index
            else self._step(index, action)
            for index, action in enumerate(actions)
        ]

    def _step(self, index: int, action: Action) -> Step:
        return Step(
            index,
            adds=self.mask(action.adds),  # what changes comes first and has low bits
            deletes=self.mask(action.deletes),
            requires=self.mask(action.requires),
            forbids=self.mask(action.forbids),
            cost_ms=action.cost_ms,
            conditional=tuple(map(self._effect, action.conditional)),
        )

    def _effect(self, effect: ConditionalEffect) -> MaskedEffect:
        return MaskedEffect(
            self.mask(effect.requires),
            self.mask(effect.forbids),
            self.mask(effect.adds),
            self.mask(effect.deletes),
        )


class TransitionSystem:
    """The moves of a problem.

    Attributes:
        start: the facts at the start, without those that never change.
        changing: the facts that can change.
        constant: the facts that always hold.
    """

    def __init__(self, steps: Sequence[Step], facts: int) -> None:
        possible, reached = _possible(steps, facts)
        deleted = 0
        for step in possible:
            deleted |= step.deletes
            for effect in step.conditional:
                deleted |= effect.deletes
        self.changing = (reached & ~facts) | (facts & deleted)
        self.constant = facts & ~self.changing
        self.start = facts & self.changing
        self._moves: dict[int, list[Move]] = {}
        self._always, self._steps_of = _indexed(
            [self._without_constants(step) for step in possible]
        )

    def moves(self, state: int) -> list[Move]:
        """What can be done in a state, in the order of the actions."""
        moves = self._moves.get(state)
        if moves is None:
            moves = self._moves[state] = sorted(self._applicable(state), key=_order)
        return moves

    def _applicable(self, state: int) -> Iterator[Move]:
        candidates = [self._always]
        rest = state
        while rest:
            bit = rest & -rest
            rest ^= bit
            if bit in self._steps_of:
                candidates.append(self._steps_of[bit])
        for steps in candidates:
            for action, requires, forbids, adds, deletes, cost_ms, conditional in steps:
                if requires & state == requires and not forbids & state:
                    for effect in conditional:
                        if effect.requires & state == effect.requires and not (
                            effect.forbids & state
                        ):
                            adds, deletes = adds | effect.adds, deletes | effect.deletes
                    yield Move(state & ~deletes | adds, action, cost_ms)

    def _without_constants(self, step: Step) -> Step:
        """A possible action: of its condition only what can change is left."""
        changing = self.changing
        return Step(
            step.action,
            step.requires & changing,
            step.forbids & changing,
            step.adds & changing,
            step.deletes,
            step.cost_ms,
            tuple(
                MaskedEffect(
                    effect.requires & changing,
                    effect.forbids & changing,
                    effect.adds & changing,
                    effect.deletes,
                )
                for effect in step.conditional
                if not effect.requires & ~(changing | self.constant)
                and not effect.forbids & self.constant
            )
            if step.conditional
            else (),
        )


def _order(move: Move) -> int:
    return move.action


def _possible(steps: Sequence[Step], facts: int) -> tuple[list[Step], int]:
    """The actions that may ever be applicable, and all facts that may ever hold."""
    blocked = 0  # facts that always hold
    while True:
        possible, reached = _relaxed(steps, facts, blocked)
        deleted = 0
        for step in possible:
            deleted |= step.deletes
            for effect in step.conditional:
                deleted |= effect.deletes
        always = facts & ~deleted
        if always == blocked or not any(step.forbids & always for step in possible):
            return possible, reached
        blocked = always


def _relaxed(steps: Sequence[Step], facts: int, blocked: int) -> tuple[list[Step], int]:
    """Reachability without deletes, and without actions that forbid a blocked fact."""
    reached = facts
    possible: list[Step] = []
    waiting = [step for step in steps if not step.forbids & blocked]
    while True:
        before = reached
        later = []
        for step in waiting:
            if step.requires & ~reached:
                later.append(step)
            else:
                possible.append(step)
                reached |= step.adds
        for step in possible:
            for effect in step.conditional:
                if not effect.requires & ~reached:
                    reached |= effect.adds
        if reached == before:
            return possible, reached
        waiting = later


def _indexed(steps: Sequence[Step]) -> tuple[list[Step], dict[int, list[Step]]]:
    """The actions without a precondition, and the others by their most selective fact."""
    count: dict[int, int] = defaultdict(int)
    for step in steps:
        for bit in _bits(step.requires):
            count[bit] += 1
    always: list[Step] = []
    steps_of: dict[int, list[Step]] = defaultdict(list)
    for step in steps:
        if step.requires:
            steps_of[min(_bits(step.requires), key=count.__getitem__)].append(step)
        else:
            always.append(step)
    return always, steps_of


def _bits(mask: int) -> Iterator[int]:
    while mask:
        bit = mask & -mask
        yield bit
        mask ^= bit
