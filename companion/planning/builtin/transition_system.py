"""The transition system of a problem: its states and the actions between them, over bit masks.

Most facts never change in a plan: events keep their value, beliefs hold, and much of what a
mission can name is out of reach. What can change is found by relaxed reachability (actions
without their deletes, Bonet and Geffner 2001); all else is a constant. A state is the set of
the facts that hold among those that can change.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence
from typing import TYPE_CHECKING, NamedTuple

from companion.errors import SearchLimit
from companion.mission.facts import Fact
from companion.planning.domain import Action, ConditionalEffect

if TYPE_CHECKING:
    import networkx

MAX_GRAPH_STATES = 100_000
"""States of a transition system that are given out as a graph."""


class MaskedEffect(NamedTuple):
    """A conditional effect over bit masks."""

    requires: int
    forbids: int
    adds: int
    deletes: int


class MaskedAction(NamedTuple):
    """An action over bit masks; `number` is its place among the problem's actions."""

    number: int
    requires: int
    forbids: int
    adds: int
    deletes: int
    cost_ms: int
    conditional: tuple[MaskedEffect, ...]


class Successor(NamedTuple):
    """The state after an action."""

    state: int
    action: int
    cost_ms: int


class FactBits:
    """Numbers facts as bits, and turns actions into masks of them.

    Args:
        actions: these are turned into masks once and kept; others are each time.

    >>> bits = FactBits(())
    >>> bits.mask({"at(A)", "lit"}), bits.mask({"lit"})
    (3, 2)
    >>> sorted(bits.facts(3))
    ['at(A)', 'lit']
    """

    def __init__(self, actions: Sequence[Action]) -> None:
        self._bit: dict[str, int] = {}  # by proposition
        self._actions = actions  # keeps the identities below their own
        self._masked: dict[int, MaskedAction] = {}
        for number, action in enumerate(actions):
            self._masked[id(action)] = self._mask_action(number, action)

    def mask(self, propositions: Iterable[str]) -> int:
        """The bits of some facts, or of the propositions of an automaton's label."""
        bits = 0
        for proposition in sorted(propositions):  # sets have no order of their own
            bits |= self.bit(proposition)
        return bits

    def bit(self, proposition: str) -> int:
        """The bit of a fact, which may be given as a proposition."""
        bit = self._bit.get(proposition)
        if bit is None:
            bit = self._bit[proposition] = 1 << len(self._bit)
        return bit

    def facts(self, mask: int) -> frozenset[Fact]:
        """The facts whose bits are in a mask."""
        return frozenset(Fact.parse(p) for p, bit in self._bit.items() if bit & mask)

    def masked(self, actions: Sequence[Action]) -> list[MaskedAction]:
        """The actions over bits, in their order."""
        known = self._masked
        return [
            masked
            if (masked := known.get(id(action))) is not None and masked.number == number
            else self._mask_action(number, action)
            for number, action in enumerate(actions)
        ]

    def _mask_action(self, number: int, action: Action) -> MaskedAction:
        return MaskedAction(
            number,
            adds=self.mask(action.adds),  # what changes comes first and has low bits
            deletes=self.mask(action.deletes),
            requires=self.mask(action.requires),
            forbids=self.mask(action.forbids),
            cost_ms=action.cost_ms,
            conditional=tuple(map(self._mask_effect, action.conditional)),
        )

    def _mask_effect(self, effect: ConditionalEffect[Fact]) -> MaskedEffect:
        return MaskedEffect(
            self.mask(effect.requires),
            self.mask(effect.forbids),
            self.mask(effect.adds),
            self.mask(effect.deletes),
        )


class TransitionSystem:
    """The states that a problem's actions lead to.

    Attributes:
        start: the facts at the start, without those that never change.
        changing: the facts that can change.
        constant: the facts that always hold.
        masked: all actions over bits.

    Args:
        actions: of the problem.
        facts: that hold at the start.
        bits: of the facts.
    """

    def __init__(self, actions: Sequence[Action], facts: frozenset[Fact], bits: FactBits) -> None:
        self.masked = bits.masked(actions)
        held = bits.mask(facts)
        possible, reached = _possible(self.masked, held)
        deleted = _deleted(possible)
        self.changing = (reached & ~held) | (held & deleted)
        self.constant = held & ~self.changing
        self.start = held & self.changing
        self._actions, self._bits = actions, bits
        self._successors: dict[int, list[Successor]] = {}
        self._always, self._by_fact = _indexed(
            [self._without_constants(action) for action in possible]
        )

    def successors(self, state: int) -> list[Successor]:
        """The states after a state, in the order of the actions."""
        found = self._successors.get(state)
        if found is None:
            found = self._successors[state] = sorted(self._applied(state), key=_action)
        return found

    def reachable(self, max_states: int) -> list[int] | None:
        """All states that can be reached, the start first; None if there are more than allowed."""
        states = [self.start]
        seen = {self.start}
        for state in states:  # grows while it is read
            for after, _, _ in self.successors(state):
                if after not in seen:
                    seen.add(after)
                    states.append(after)
            if len(states) > max_states:
                return None
        return states

    def after(self, state: int, action: int) -> int:
        """The state after an action that is applicable, given by its number."""
        return next(s.state for s in self.successors(state) if s.action == action)

    def to_networkx(self, max_states: int = MAX_GRAPH_STATES) -> networkx.MultiDiGraph:
        """All states that can be reached, and the actions between them, as a graph.

        Nodes are numbered, 0 is the start; each has its `facts`, of those that can change. Edges
        have the `action` by name, which is their key, and its `cost_ms`. The graph has the facts
        that always hold as `constant`.

        Raises:
            SearchLimit: there are more states than `max_states`.

        >>> from companion.planning.domain import WAIT
        >>> graph = TransitionSystem([WAIT], frozenset({"day"}), FactBits(())).to_networkx()
        >>> list(graph.edges(keys=True)), graph.nodes[0]["facts"], graph.graph["constant"]
        ([(0, 0, 'wait')], frozenset(), frozenset({'day'}))
        """
        import networkx

        graph = networkx.MultiDiGraph(constant=self._bits.facts(self.constant))
        states = [self.start]
        number_of = {self.start: 0}
        for number, state in enumerate(states):  # grows while it is read
            graph.add_node(number, facts=self._bits.facts(state))
            for after, action, cost_ms in self.successors(state):
                if after not in number_of:
                    number_of[after] = len(states)
                    states.append(after)
                name = self._actions[action].name
                graph.add_edge(number, number_of[after], name, action=name, cost_ms=cost_ms)
            if len(states) > max_states:
                raise SearchLimit(f"{max_states:,} states of the transition system")
        return graph

    def _applied(self, state: int) -> Iterator[Successor]:
        candidates = [self._always]
        rest = state
        while rest:
            bit = rest & -rest
            rest ^= bit
            if bit in self._by_fact:
                candidates.append(self._by_fact[bit])
        for actions in candidates:
            for number, requires, forbids, adds, deletes, cost_ms, conditional in actions:
                if requires & state == requires and not forbids & state:
                    for effect in conditional:
                        if effect.requires & state == effect.requires and not (
                            effect.forbids & state
                        ):
                            adds, deletes = adds | effect.adds, deletes | effect.deletes
                    yield Successor(state & ~deletes | adds, number, cost_ms)

    def _without_constants(self, action: MaskedAction) -> MaskedAction:
        """A possible action: of its condition only what can change is left."""
        changing = self.changing
        return MaskedAction(
            action.number,
            action.requires & changing,
            action.forbids & changing,
            action.adds & changing,
            action.deletes,
            action.cost_ms,
            tuple(
                MaskedEffect(
                    effect.requires & changing,
                    effect.forbids & changing,
                    effect.adds & changing,
                    effect.deletes,
                )
                for effect in action.conditional
                if not effect.requires & ~(changing | self.constant)
                and not effect.forbids & self.constant
            )
            if action.conditional
            else (),
        )


def _action(successor: Successor) -> int:
    return successor.action


def _possible(actions: Sequence[MaskedAction], facts: int) -> tuple[list[MaskedAction], int]:
    """The actions that may ever be applicable, and all facts that may ever hold."""
    blocked = 0  # facts that always hold
    while True:
        possible, reached = _relaxed(actions, facts, blocked)
        always = facts & ~_deleted(possible)
        if always == blocked or not any(action.forbids & always for action in possible):
            return possible, reached
        blocked = always


def _deleted(actions: Sequence[MaskedAction]) -> int:
    """All facts that some of the actions may delete."""
    deleted = 0
    for action in actions:
        deleted |= action.deletes
        for effect in action.conditional:
            deleted |= effect.deletes
    return deleted


def _relaxed(
    actions: Sequence[MaskedAction], facts: int, blocked: int
) -> tuple[list[MaskedAction], int]:
    """Reachability without deletes, and without actions that forbid a blocked fact."""
    reached = facts
    possible: list[MaskedAction] = []
    waiting = [action for action in actions if not action.forbids & blocked]
    while True:
        before = reached
        later = []
        for action in waiting:
            if action.requires & ~reached:
                later.append(action)
            else:
                possible.append(action)
                reached |= action.adds
        for action in possible:
            for effect in action.conditional:
                if not effect.requires & ~reached:
                    reached |= effect.adds
        if reached == before:
            return possible, reached
        waiting = later


def _indexed(
    actions: Sequence[MaskedAction],
) -> tuple[list[MaskedAction], dict[int, list[MaskedAction]]]:
    """The actions without a precondition, and the others by their most selective fact."""
    count: dict[int, int] = defaultdict(int)
    for action in actions:
        for bit in _bits(action.requires):
            count[bit] += 1
    always: list[MaskedAction] = []
    by_fact: dict[int, list[MaskedAction]] = defaultdict(list)
    for action in actions:
        if action.requires:
            by_fact[min(_bits(action.requires), key=count.__getitem__)].append(action)
        else:
            always.append(action)
    return always, by_fact


def _bits(mask: int) -> Iterator[int]:
    while mask:
        bit = mask & -mask
        yield bit
        mask ^= bit
