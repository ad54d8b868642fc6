"""The product of the transition system and the automata, built only where the search needs it.

A product state is a set of facts together with one state per automaton (Section III-A):

    s -> s'  and  z_i --L(s')--> z_i'  for every i   gives   (s, z) -> (s', z')

The automata have already read the position at which they are (see `lasso.py`). A nondeterministic
automaton makes several edges, so a path through the product fixes one run of each. Acceptance stays
generalized. A node is a product state together with the acceptance marks that were met on the way
into it; so a loop meets a mark exactly if it passes a node that has it.

These are removed first, to keep the product small:
1. Constants (`transition_system.py`), from facts and automata (`ltl/restriction.py`); only the
   places are left of a patrol.
2. Conjuncts that the others imply (`implied.py`).
3. Facts that nothing reads. Facts that only a one-shot goal needs are forgotten
   (`forgotten_facts.py`).
"""

from __future__ import annotations

import itertools
import math
from collections import Counter
from collections.abc import Iterator, Sequence
from functools import cached_property, partial, reduce
from operator import or_
from typing import TYPE_CHECKING

import numpy as np
from scipy.sparse import csr_array

from companion.errors import SearchLimit
from companion.mission.facts import Fact, at
from companion.planning.builtin.entered_nodes import EnteredNodes, Node, is_no_less, takes_of
from companion.planning.builtin.forgotten_facts import forgotten_facts, unread_facts
from companion.planning.builtin.masked_actions import KnownActions
from companion.planning.builtin.masked_automaton import MaskedAutomaton, RestrictedConjunct
from companion.planning.builtin.restrictions import Restrictions
from companion.planning.builtin.transition_system import TransitionSystem
from companion.planning.domain import WAIT
from companion.planning.effort import BEFORE_FLIGHT, PRODUCT_EDGE_US
from companion.planning.lasso import Problem
from companion.slices import spent

if TYPE_CHECKING:
    import networkx

MIN_ONE_SHOT_GOALS = 4
"""From this many one-shot goals on, they are kept out of the product; each would double it."""

MAX_LETTERS = 2_000
"""The most states of the transition system for which implied conjuncts are searched."""

_PART_US = 20
_NODE_US = 5
_JOINT_MOVE_US = 4
_STEPS_OF_NODE = 30


class Product:
    """The reachable product of a problem.

    Attributes:
        system: the transition system under the product.
        nodes: number of nodes.
        initial: nodes at which a plan may begin.
        marks: for each node the marks (bits) met on the way into it.
        state_of: for each node its product state, as the number of the first node with the same
            one, apart from forgotten facts. The same continuations are possible from all these
            nodes, so a plan may enter a loop at any of them.
        facts_of: for each node its facts, as the number of the first node with the same ones.
        all_marks: the marks (bits) that a loop has to meet.
        waiting_since_ms: for each of them, since when its conjunct waits; empty if nothing does.
        automata: the automata that are read, one for each place of a node's automaton states.
        one_shot_goals: for each goal that is kept out of the product, the nodes that meet it.
        ends, costs, actions: of the edges; the edges of node n are first[n] to first[n + 1].
            Between two nodes only the cheapest edge is kept, in the order of the actions, and edges
            that charge, or take less time or energy where that matters.

    Args:
        problem: the problem to plan for.
        known: actions and facts as bits, kept from plan to plan.
        restrictions: of the conjuncts, kept from plan to plan.
        max_edges: limit of the search.
        min_goals: from this many one-shot goals on, they are kept out.
        with_implied: whether conjuncts that the others imply are read as well.

    Raises:
        SearchLimit: there are more edges, or more initial states, than `max_edges`.
    """

    def __init__(
        self,
        problem: Problem,
        known: KnownActions,
        restrictions: Restrictions,
        max_edges: int = BEFORE_FLIGHT.product_edges,
        min_goals: int = MIN_ONE_SHOT_GOALS,
        with_implied: bool = False,
    ) -> None:
        self._problem, self._bits, self._max_edges = problem, known.bits, max_edges
        self.system = TransitionSystem(problem.actions, problem.facts, known)
        self._restrictions = restrictions
        self._takes = takes_of(problem)
        self._parts: list[RestrictedConjunct] = []  # whose automata are read
        self.automata: list[MaskedAutomaton] = []
        self.waiting_since_ms: list[int] = []
        choices: list[list[int]] = []
        goals: list[tuple[MaskedAutomaton, int]] = []
        marks = 0
        parts = self._restricted()
        readers = Counter(p for part in parts for p in part.automaton.propositions)
        if problem.energy is not None:
            readers.update(map(at, problem.energy.floors))
        self.system.drop_idle(*self._demanded(parts), self._better_than_rest())
        self.system.leave_out(unread_facts(self.system, readers, self._bits))
        if not with_implied:
            letters = partial(self.system.reachable, MAX_LETTERS)
            parts = restrictions.implications.without_implied(parts, letters, self._bits)
        is_worth_it = sum(part.is_one_shot for part in parts) >= min_goals
        for part in parts:
            spent(_PART_US)
            automaton = restrictions.masked(part, marks, self._bits)
            if part.is_one_shot and is_worth_it:
                goals.append((automaton, part.states[0]))
            else:
                choices.append(part.states)
                self._parts.append(part)
                self.automata.append(automaton)
                marks += part.automaton.marks
                if part.waiting_since_ms is not None:
                    self.waiting_since_ms += [part.waiting_since_ms] * part.automaton.marks
        if math.prod(map(len, choices)) > max_edges:
            raise SearchLimit(f"{max_edges:,} initial states of the product")
        self._forgotten = forgotten_facts(self.system, goals, readers, self._bits)
        self.system.forget(self._forgotten)
        self.all_marks = (1 << marks) - 1
        initial = [(self.system.start, states, 0) for states in itertools.product(*choices)]
        self._nodes = self._explore(initial)
        self.one_shot_goals = [
            [node for node, (facts, _, _) in enumerate(self._nodes) if goal.leaves(pending, facts)]
            for goal, pending in goals
        ]

    @property
    def edges_with_goals(self) -> int:
        """About how many edges the product would have with the one-shot goals in it."""
        return len(self.ends) << len(self.one_shot_goals)

    @property
    def nodes(self) -> int:
        """The number of nodes."""
        return len(self.marks)

    def bit(self, proposition: str) -> int:
        """The bit of a fact."""
        return self._bits.bit(proposition)

    def facts(self, node: int) -> int:
        """The facts of a node, as bits."""
        return self._nodes[node][0]

    def letter(self, node: int) -> frozenset[Fact]:
        """All facts that hold at a node, including constants."""
        return self.system.constant | self._bits.facts(self.facts(node) & self.system.changing)

    def automaton_states(self, node: int) -> tuple[int, ...]:
        """The automaton states of a node."""
        return self._nodes[node][1]

    @cached_property
    def least_ms(self) -> int:
        """The cost of the cheapest edge."""
        return int(self.costs.min())

    @property
    def dijkstra_steps(self) -> int:
        """About how many steps a shortest-path search takes."""
        return dijkstra_steps(self.nodes, len(self.ends))

    @cached_property
    def max_laps(self) -> int:
        """The most laps of actions that a cycle of the product takes, if the loop is accepted."""
        returning = [part for part in self._parts if part.restriction.can_return]
        if not returning:
            return 1  # a run finally stays in a state, where all laps do the same
        letters = {facts for facts, _, _ in self._nodes}
        laps = (self._restrictions.max_laps(part, letters, self._bits) for part in returning)
        return math.prod(laps)

    def cost_matrix(self) -> csr_array:
        """Costs of the edges, as a sparse matrix from nodes to nodes."""
        return self._cost_matrix

    @cached_property
    def _cost_matrix(self) -> csr_array:
        shape = (self.nodes, self.nodes)
        if not self._takes:
            return csr_array((self.costs.astype(float), self.ends, self.first), shape=shape)
        sources = np.repeat(np.arange(self.nodes), np.diff(self.first))
        order = np.lexsort((self.costs, self.ends, sources))
        pairs = np.stack((sources, self.ends))[:, order]  # scipy's searches hang on a pair twice
        is_new = np.append(True, (np.diff(pairs) != 0).any(axis=0))[: len(order)]
        costs = self.costs[order].astype(float)
        return csr_array((costs[is_new], tuple(pairs[:, is_new])), shape=shape)

    def edges(self, node: int) -> Iterator[tuple[int, int, int]]:
        """Action, cost and end of each edge that leaves a node."""
        span = slice(self.first[node], self.first[node + 1])
        return zip(
            self.actions[span].tolist(),
            self.costs[span].tolist(),
            self.ends[span].tolist(),
            strict=True,
        )

    def to_networkx(self) -> networkx.DiGraph:
        """The explored product as a graph.

        Each node has a number and these attributes: the `facts` that hold, of those that can
        change; the `automaton_states`, one for each of the graph's `conjuncts`; the `marks` met on
        the way into it; the `goals` that it meets, of the `one_shot_goals` (their number) kept out
        of the product. Each edge has the `action` by name and its `cost_ms`. The graph also has the
        `initial` nodes, the number of `marks`, and as `constant` the facts that always hold. The
        automata are those under the constants, so their states are not numbered as in the problem.
        """
        import networkx

        graph = networkx.DiGraph(
            initial=tuple(self.initial),
            conjuncts=tuple(str(part.conjunct.formula) for part in self._parts),
            one_shot_goals=len(self.one_shot_goals),
            marks=self.all_marks.bit_length(),
            constant=self.system.constant,
        )
        met_at = [frozenset(nodes) for nodes in self.one_shot_goals]
        for node, (facts, states, marks) in enumerate(self._nodes):
            graph.add_node(
                node,
                facts=self._bits.facts(facts & self.system.changing),
                automaton_states=states,
                marks=tuple(mark for mark in range(marks.bit_length()) if marks >> mark & 1),
                goals=tuple(goal for goal, nodes in enumerate(met_at) if node in nodes),
            )
        for node in range(self.nodes):
            for action, cost_ms, end in self.edges(node):
                name = self._problem.actions[action].name
                graph.add_edge(node, end, action=name, cost_ms=cost_ms)
        return graph

    def _demanded(self, parts: Sequence[RestrictedConjunct]) -> tuple[int, int]:
        """The facts (bits) that may be demanded to be true, and those to be false.

        If not only the lap counts, each fact that is read may matter either way, because a fact
        that is not undone may have to be made in the prefix. So may the vehicle's place on a
        battery, because of the floors.
        """
        energy = self._problem.energy
        read = set[str](() if energy is None else map(at, energy.floors))
        if not self._takes:  # other objectives are for problems without battery and time bounds
            read.update(*(part.automaton.propositions for part in parts))
        positive = read.union(*(part.literals.positive for part in parts))
        negative = read.union(*(part.literals.negative for part in parts))
        return self._bits.mask(positive), self._bits.mask(negative)

    def _better_than_rest(self) -> frozenset[int]:
        """The actions that charge, or take less time or energy than a rest, where that matters."""
        rests = (n for n, action in enumerate(self._problem.actions) if action is WAIT)
        if not self._takes or (rest := next(rests, None)) is None:
            return frozenset()
        own = self._takes[rest]
        return frozenset(n for n, each in enumerate(self._takes) if not is_no_less(each, own))

    def _restricted(self) -> list[RestrictedConjunct]:
        """The conjuncts under the constants, without those that hold in any case."""
        problem, constants = self._problem, self.system.constant_value
        since_ms = problem.waiting_since_ms or (None,) * len(problem.conjuncts)
        every = zip(problem.conjuncts, problem.automaton_states, since_ms, strict=True)
        parts = (
            RestrictedConjunct.of(each, self._restrictions.of(each, constants), states, since)
            for each, states, since in every
        )
        return [part for part in parts if not part.accepts_all]

    def _explore(self, initial: list[Node]) -> list[Node]:
        """Finds all nodes and edges from the initial nodes on; returns the nodes."""
        self.initial = list(range(len(initial)))
        nodes = list(initial)
        number_of = {node: number for number, node in enumerate(initial)}
        entered: dict[tuple[int, ...], EnteredNodes] = {}
        first, ends, costs, actions = [0], [], [], []
        for facts, states, _ in nodes:  # grows while it is read
            into = entered.get(states)
            if into is None:
                moves = partial(self._joint_moves, states=states)
                into = entered[states] = EnteredNodes(moves, nodes, number_of, self._takes)
            leaving = into.edges(self.system.successors(facts))
            ends += leaving.states
            costs += leaving.costs
            actions += leaving.actions
            first.append(len(ends))
            spent(PRODUCT_EDGE_US * len(leaving.states) + _NODE_US)
            if len(ends) > self._max_edges:
                raise SearchLimit(f"{self._max_edges:,} edges of the product")
        self.marks = [marks for _, _, marks in nodes]
        states_of: dict[tuple[int, tuple[int, ...]], int] = {}
        facts_of: dict[int, int] = {}
        self.state_of, self.facts_of = [], []
        spent(_NODE_US * len(nodes))
        for number, (held, own, _) in enumerate(nodes):
            kept = held & ~self._forgotten
            self.state_of.append(states_of.setdefault((kept, own), number))
            self.facts_of.append(facts_of.setdefault(kept, number))
        self.first = np.array(first, np.int32)
        self.ends = np.array(ends, np.int32)
        self.costs = np.array(costs, np.int64)
        self.actions = np.array(actions, np.int32)
        return nodes

    def _joint_moves(
        self, facts: int, states: tuple[int, ...]
    ) -> list[tuple[tuple[int, ...], int]]:
        """All joint moves of the automata on the label of some facts, with their marks."""
        each = [a.successors(z, facts) for a, z in zip(self.automata, states, strict=True)]
        count = math.prod(map(len, each))
        if count > self._max_edges:
            raise SearchLimit(f"{self._max_edges:,} joint moves of the automata")
        spent(_JOINT_MOVE_US * count)
        return [
            (tuple([z for z, _ in moves]), reduce(or_, [marks for _, marks in moves], 0))
            for moves in itertools.product(*each)
        ]


def dijkstra_steps(nodes: int, edges: int) -> int:
    """About how many steps a shortest-path search takes, at one step for each edge.

    Taking a node off a heap costs as much as thirty edges.
    """
    return edges + _STEPS_OF_NODE * nodes
