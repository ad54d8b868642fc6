"""A strong component of a product, in which laps are searched."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property, reduce
from hashlib import blake2b
from operator import and_

import numpy as np
from numpy.typing import NDArray

from companion.ltl.time_bounds import Revisit
from companion.planning.builtin.loops import essential_targets
from companion.planning.timed.timed_product import TimedProduct
from companion.planning.timed.timed_step import TimedStep
from companion.slices import spent

_STEP_US = 1.0
_NAMED_STEP_US = 4.0


class TimedComponent:
    """The states of a component, the steps within it, and the marks that a lap has to meet.

    Attributes:
        nodes: its nodes in the product.
        states: its states, as `TimedStep.end` numbers them.
        targets_of: by mark, the nodes at which it is met.
        all: the marks, as bits.
        all_clocks: the clocks, as bits.
    """

    def __init__(
        self,
        graph: TimedProduct,
        nodes: NDArray[np.intp],
        targets_of: list[frozenset[int]] | None = None,
    ) -> None:
        self._graph = graph
        self.nodes = nodes
        within = set(nodes.tolist())
        if targets_of is None:
            targets_of = essential_targets(graph.product, nodes)
        self.targets_of = targets_of
        self.all = (1 << len(self.targets_of)) - 1
        self.all_clocks = (1 << len(graph.least)) - 1
        marks_at: dict[int, int] = {}
        for mark, targets in enumerate(self.targets_of):
            for target in targets:
                marks_at[target] = marks_at.get(target, 0) | 1 << mark
        self._steps: dict[int, list[tuple[TimedStep, int]]] = {}
        for node in nodes.tolist():
            state = graph.product.state_of[node]
            if state not in self._steps:
                self._steps[state] = [
                    (step, marks_at.get(step.node, 0))
                    for step in graph.steps(state)
                    if step.node in within
                ]
                spent(_STEP_US * len(self._steps[state]))
        self.states = list(self._steps)

    def steps(self, state: int) -> Sequence[tuple[TimedStep, int]]:
        """The steps that leave a state, and the marks (bits) that each meets."""
        return self._steps.get(state, ())

    def with_marks(self, marks: Sequence[int]) -> TimedComponent:
        """The component, if a lap only has to meet some of the marks, which are renumbered."""
        return TimedComponent(self._graph, self.nodes, [self.targets_of[mark] for mark in marks])

    @property
    def free(self) -> int:
        """The marks (bits) that are always met by what clocks demand."""
        graph = self._graph
        goals = [
            graph.goals(clock) for clock, b in enumerate(graph.bounds) if isinstance(b, Revisit)
        ]
        asked_for = [frozenset(np.intersect1d(nodes, self.nodes).tolist()) for nodes in goals]
        is_free = [any(nodes <= targets for nodes in asked_for) for targets in self.targets_of]
        return sum(1 << mark for mark, free in enumerate(is_free) if free)

    @cached_property
    def by_action(self) -> dict[int, dict[int, list[tuple[TimedStep, int]]]]:
        """The steps and their marks, by state and action."""
        found: dict[int, dict[int, list[tuple[TimedStep, int]]]] = {}
        for state, steps in self._steps.items():
            own = found[state] = {}
            for step, marks in steps:
                own.setdefault(step.action, []).append((step, marks))
        return found

    @cached_property
    def fingerprint(self) -> bytes:
        """Equal for two components, of whatever problems, that have the same laps.

        It is made of everything that decides on laps: the steps with what they take and meet, and
        what states do with the clocks. What never changes within the component is left out.
        """
        graph, product = self._graph, self._graph.product
        facts = [product.facts(state) for state in self.states]
        always = reduce(and_, facts, -1)
        own = [product.automaton_states(state) for state in self.states]
        moving = [i for i, each in enumerate(zip(*own, strict=True)) if len(set(each)) > 1]
        names = {
            state: (held & ~always, *(states[i] for i in moving))
            for state, held, states in zip(self.states, facts, own, strict=True)
        }
        spent(_NAMED_STEP_US * sum(map(len, self._steps.values())))
        did = [action.name for action in graph.all_actions]
        steps = sorted(
            (
                names[state],
                names[step.end],
                did[step.action],
                step[1:3],
                step.drain,
                step.charge or (),
                marks,
            )
            for state, leaving in self._steps.items()
            for step, marks in leaving
        )
        readings = sorted((name, graph.reading(state)) for state, name in names.items())
        described = graph.limits_ms, graph.least, steps, readings
        return blake2b(repr(described).encode(), digest_size=16).digest()

    def anchors(self) -> list[int]:
        """States of which every lap passes one; the smallest known set.

        Among sets of equal size, the states where the clock with the least limit starts again.
        """
        graph = self._graph
        best = (len(self.states), 0, self.states)
        for clock, bound in enumerate(graph.bounds):
            if isinstance(bound, Revisit):
                states = [state for state in self.states if graph.is_goal(clock, state)]
                best = min(best, (len(states), bound.limit_ms - (1 << 60), states))
        for targets in self.targets_of:
            states = sorted({graph.product.state_of[node] for node in targets})
            best = min(best, (len(states), 0, states))
        return best[2]

    def is_never_met(self) -> bool:
        """Whether a mark cannot be met between two goals of a clock that always runs."""
        graph = self._graph
        for clock, bound in enumerate(graph.bounds):
            if isinstance(bound, Revisit):
                goals = np.intersect1d(graph.goals(clock), self.nodes)
                there, back = graph.durations_from(goals), graph.durations_to(goals)
                for targets in self.targets_of:
                    at = sorted(targets)
                    if (there[at] + back[at]).min() > graph.limits_ms[clock]:
                        return True
        return False
