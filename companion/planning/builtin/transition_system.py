"""The transition system of a problem: its states and the actions between them, as bit masks.

Most facts never change in a plan: events keep their value, beliefs hold, and much of what a mission
can name is out of reach. Relaxed reachability (actions without their deletes, Bonet and Geffner
2001) finds what can change; all other facts are constants. A state is the set of the facts that
hold among those that some action changes.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Sequence
from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple

from companion.errors import SearchLimit
from companion.mission.facts import Fact
from companion.planning.builtin.masked_actions import ActionGroup, KnownActions
from companion.planning.domain import Action
from companion.slices import spent

if TYPE_CHECKING:
    import networkx

_STEP_US = 0.5
_GROUP_US = 0.3

MAX_GRAPH_STATES = 100_000
"""The most states of a transition system that is exported as a graph."""


class Successors(NamedTuple):
    """The states after a state, each with the action and its cost, in the order of the actions."""

    states: list[int]
    actions: list[int]
    costs: list[int]


class TransitionSystem:
    """The states that a problem's actions lead to.

    Attributes:
        start: the facts at the start.
        changing: the facts that can change.

    Args:
        actions: the actions of the problem.
        facts: the facts that hold at the start.
        known: actions as bits, kept from plan to plan.
    """

    def __init__(
        self, actions: Sequence[Action], facts: frozenset[Fact], known: KnownActions
    ) -> None:
        groups = known.given(tuple(actions), facts)
        held = known.state(facts)
        self._possible, reached = _possible(groups, held)
        deleted = _deleted(self._possible)
        self.changing = (reached & ~held) | (held & deleted)
        self.start = held
        self._actions, self._facts, self._bits = actions, facts, known.bits
        self._forgotten = self._left_out = 0
        self._successors: dict[int, Successors] = {}
        self._always, self._by_fact = _indexed(self._possible)

    def only_made(self, facts: int) -> int:
        """Those of some facts that are false at the start, and that no action reads or deletes."""
        facts &= ~self.start & ~_deleted(self._possible)
        for group in self._possible:
            facts &= ~group.reads
        return facts

    def drop_idle(self, wanted: int, unwanted: int, kept: frozenset[int] = frozenset()) -> None:
        """Drops actions that do nothing for the task, and enable no action that does.

        Such an action makes no wanted fact true and no unwanted fact false. If the problem has a
        rest, that can replace it at no extra cost. An action that undoes what is wanted also has to
        cost more, and no other action may undo it: then no shortest lap contains it, and a lap that
        closes after it also closes without it.

        Args:
            wanted: the facts (bits) that may be demanded to be true.
            unwanted: the facts (bits) that may be demanded to be false.
            kept: numbers of actions that stay, together with those that make them possible.
        """
        rest_ms = min((ms for group in self._possible for ms in group.rests_ms), default=None)
        if rest_ms is None:
            return
        idle, needed = set(self._possible), self._possible
        added = deleted = 0  # by actions that stay
        while needed:
            spent(_GROUP_US * len(idle))
            needed = [
                group
                for group in idle
                if group.may_add & (wanted | unwanted & added)
                or group.deletes & (unwanted | wanted & deleted)
                or not kept.isdisjoint(group.numbers)
            ]
            idle.difference_update(needed)
            for group in needed:
                of_effects = group.reads if group.conditional else 0  # an effect may be bad or good
                wanted |= group.requires | of_effects
                unwanted |= group.forbids | of_effects
                added, deleted = added | group.may_add, deleted | group.deletes
        gone = {
            group
            for group in idle
            if not group.rests_ms
            and min(group.costs)
            >= rest_ms + bool(group.may_add & unwanted or group.deletes & wanted)
        }
        if gone:
            self._possible = [group for group in self._possible if group not in gone]
            self._always, self._by_fact = _indexed(self._possible)
            self._successors.clear()

    def forget(self, facts: int) -> None:
        """From now on these facts, which no action reads, hold only right after they are made."""
        if facts != self._forgotten:
            self._forgotten = facts
            self._successors.clear()

    def leave_out(self, facts: int) -> None:
        """From now on no state contains these facts, which are false at the start."""
        self._left_out = facts
        self._successors.clear()

    @cached_property
    def possible(self) -> list[int]:
        """The numbers of the actions that may ever become applicable."""
        return sorted(number for group in self._possible for number in group.numbers)

    @cached_property
    def constant(self) -> frozenset[Fact]:
        """The facts that always hold."""
        return self._facts - self._bits.facts(self.changing)

    def constant_value(self, proposition: str) -> bool | None:
        """The value of a proposition that never changes; None for other propositions."""
        is_changing = self._bits.bit(proposition) & self.changing
        return None if is_changing else proposition in self._facts

    def successors(self, state: int) -> Successors:
        """The states after a state."""
        found = self._successors.get(state)
        if found is None:
            found = self._successors[state] = self._applied(state)
        return found

    def steps(self, state: int) -> Iterator[tuple[int, int, int]]:
        """The states after a state, each with the action and its cost."""
        return zip(*self.successors(state), strict=True)

    def reachable(self, max_states: int) -> list[int] | None:
        """All reachable states, the start first; None if there are more than `max_states`."""
        states = [self.start]
        seen = {self.start}
        for state in states:  # grows while it is read
            successors = self.successors(state).states
            spent(_STEP_US * len(successors))
            for after in successors:
                if after not in seen:
                    seen.add(after)
                    states.append(after)
            if len(states) > max_states:
                return None
        return states

    def after(self, state: int, action: int) -> int:
        """The state after an action that is applicable, given by its number."""
        found = self.successors(state)
        return found.states[found.actions.index(action)]

    def to_networkx(self, max_states: int = MAX_GRAPH_STATES) -> networkx.MultiDiGraph:
        """All reachable states, and the actions between them, as a graph.

        Nodes are numbered; 0 is the start. Each has its `facts`, of those that can change. Edges
        have the `action` by name, which is their key, and its `cost_ms`. The graph has, as
        `constant`, the facts that always hold.

        Raises:
            SearchLimit: there are more states than `max_states`.

        >>> from companion.planning.domain import WAIT
        >>> graph = TransitionSystem([WAIT], frozenset({"day"}), KnownActions()).to_networkx()
        >>> list(graph.edges(keys=True)), graph.nodes[0]["facts"], graph.graph["constant"]
        ([(0, 0, 'wait')], frozenset(), frozenset({'day'}))
        """
        import networkx

        graph = networkx.MultiDiGraph(constant=self.constant)
        states = [self.start]
        number_of = {self.start: 0}
        for number, state in enumerate(states):  # grows while it is read
            graph.add_node(number, facts=self._bits.facts(state & self.changing))
            for after, action, cost_ms in self.steps(state):
                if after not in number_of:
                    number_of[after] = len(states)
                    states.append(after)
                name = self._actions[action].name
                graph.add_edge(number, number_of[after], name, action=name, cost_ms=cost_ms)
            if len(states) > max_states:
                raise SearchLimit(f"{max_states:,} states of the transition system")
        return graph

    def _applied(self, state: int) -> Successors:
        candidates = [*self._always]
        for bit in _bits(state):
            candidates += self._by_fact.get(bit, ())
        applicable = [group for group in candidates if group.is_applicable(state)]
        applicable.sort(key=_first_number)
        states: list[int] = []
        actions: list[int] = []
        costs: list[int] = []
        is_sorted = True
        for group in applicable:
            is_sorted = is_sorted and (not actions or actions[-1] < group.numbers[0])
            states += group.ends(state)
            actions += group.numbers
            costs += group.costs
        if gone := state & self._forgotten | self._left_out:
            states = [end & ~gone for end in states]
        if is_sorted:
            return Successors(states, actions, costs)
        order = sorted(range(len(actions)), key=actions.__getitem__)
        return Successors(
            [states[i] for i in order], [actions[i] for i in order], [costs[i] for i in order]
        )


def _first_number(group: ActionGroup) -> int:
    return group.numbers[0]


def _possible(groups: Sequence[ActionGroup], facts: int) -> tuple[list[ActionGroup], int]:
    """The actions that may ever become applicable, and all facts that may ever hold."""
    blocked = 0  # facts that always hold
    while True:
        possible, reached = _relaxed(groups, facts, blocked)
        always = facts & ~_deleted(possible)
        if always == blocked or not any(group.forbids & always for group in possible):
            return possible, reached
        blocked = always


def _deleted(groups: Sequence[ActionGroup]) -> int:
    """All facts that some action may delete."""
    deleted = 0
    for group in groups:
        deleted |= group.deletes
    return deleted


def _relaxed(
    groups: Sequence[ActionGroup], facts: int, blocked: int
) -> tuple[list[ActionGroup], int]:
    """Reachability without deletes, and without actions that forbid a blocked fact."""
    reached = facts
    possible: list[ActionGroup] = []
    waiting = [group for group in groups if not group.forbids & blocked]
    while True:
        before = reached
        later = []
        spent(_GROUP_US * (len(waiting) + len(possible)))
        for group in waiting:
            if group.requires & ~reached:
                later.append(group)
            else:
                possible.append(group)
                reached |= group.adds
        for group in possible:
            for effect in group.conditional:
                if not effect.condition.requires & ~reached:
                    reached |= effect.adds
        if reached == before:
            return possible, reached
        waiting = later


def _indexed(
    groups: Sequence[ActionGroup],
) -> tuple[list[ActionGroup], dict[int, list[ActionGroup]]]:
    """The actions without a precondition, and the others by their most selective fact."""
    count: dict[int, int] = defaultdict(int)
    for group in groups:
        for bit in _bits(group.requires):
            count[bit] += 1
    always: list[ActionGroup] = []
    by_fact: dict[int, list[ActionGroup]] = defaultdict(list)
    for group in groups:
        if group.requires:
            by_fact[min(_bits(group.requires), key=count.__getitem__)].append(group)
        else:
            always.append(group)
    return always, by_fact


def _bits(mask: int) -> Iterator[int]:
    while mask:
        bit = mask & -mask
        yield bit
        mask ^= bit
