"""Compilations with one automaton for each conjunct and generalized acceptance (v4, v5).

One automaton for the whole task grows exponentially with the task, and its one acceptance set
fixes in which order a lap meets its parts. Here each conjunct keeps its own small automaton, and
a flag for each acceptance set says that the loop has met it, in whatever order.

They take turns: the vehicle acts, the automata read the facts that hold then, the vehicle acts. Of
a nondeterministic automaton the planner chooses each transition and with it one run, so no set of
states has to be tracked, and none to be collapsed where the loop begins. A word without a run
leaves no transition to choose.

This module has the part that both encodings share; `conditional.py` makes v4 of it and
`strips.py` v5.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import combinations
from typing import ClassVar

from companion.ltl.automaton import BuchiAutomaton, Transition
from companion.ltl.restriction import restricted
from companion.planning.compilation.classical import ClassicalAction, ClassicalProblem, Fluent
from companion.planning.compilation.reduced_task import ReducedTask
from companion.planning.lasso import Problem
from companion.planning.objective import Encoding, Objective

ACT, BEFORE, LP_S, IN_LP, END_DONE = "actTurn", "inPrefix", "LpS", "inLp", "endDone"
NOTHING: frozenset[Fluent] = frozenset()


@dataclass(frozen=True)
class Part:
    """One automaton under the constants.

    Attributes:
        number: its place among the parts, for names.
        states: those it may be in.
    """

    number: int
    automaton: BuchiAutomaton
    states: tuple[int, ...]

    def at(self, state: int) -> Fluent:
        """The fluent: the automaton is in a state."""
        return f"currBA({self.number}, {state})"

    def req(self, state: int) -> Fluent:
        """The fluent: the loop begins in a state."""
        return f"reqLp({self.number}, {state})"

    def seen(self, mark: int) -> Fluent:
        """The fluent: the loop has met a mark."""
        return f"seenBA({self.number}, {mark})"

    @property
    def turn(self) -> Fluent:
        """The fluent: the automaton is to read the facts."""
        return f"BAturn({self.number})"

    @property
    def start(self) -> Fluent:
        """The fluent: the first state is to be chosen."""
        return f"BAstart({self.number})"

    @property
    def end(self) -> Fluent:
        """The fluent: the automaton is where the loop began."""
        return f"endBA({self.number})"

    @property
    def is_deterministic(self) -> bool:
        """Whether the automaton is in one state, and each letter leads to at most one."""
        return len(self.states) == 1 and not any(
            a.label.positive.isdisjoint(b.label.negative)
            and a.label.negative.isdisjoint(b.label.positive)
            for leaving in self.automaton.outgoing
            for a, b in combinations(leaving, 2)
        )

    @property
    def marks(self) -> frozenset[Fluent]:
        """The fluents: the loop has met all marks."""
        return frozenset(map(self.seen, range(self.automaton.marks)))


@dataclass(frozen=True, slots=True)
class VariableValue:
    """A value of a variable: that a fluent holds, or that it does not.

    Attributes:
        memory: the fluent for it at the beginning of the loop.
    """

    fluent: Fluent
    holds: bool
    memory: Fluent

    @property
    def positive(self) -> Fluent:
        """The fluent that holds with it, where each has its complement."""
        return self.fluent if self.holds else complement(self.fluent)


def complement(fluent: Fluent) -> Fluent:
    """The fluent that holds where another one does not."""
    return f"not({fluent})"


def parts(problem: Problem, task: ReducedTask) -> Iterator[Part]:
    """The automata that are left under the constants; those that accept anything are not."""
    found = zip(problem.conjuncts, problem.automaton_states, strict=True)
    for number, (conjunct, whole) in enumerate(found):
        rest = restricted(conjunct.automaton, task.constants(conjunct.automaton.propositions))
        states = tuple(rest.states(whole))
        if rest.everything.isdisjoint(states):
            yield Part(number, rest.automaton, states)


class DecomposedEncoding(ABC):
    """The part that v4 and v5 share. Fluents of which one holds at a time say whose turn it is."""

    encoding: ClassVar[Encoding]

    def __init__(self, task: ReducedTask, parts: tuple[Part, ...], objective: Objective) -> None:
        self.task = task
        self.parts = parts
        is_lap = objective is Objective.LAP
        self.weight = task.lap_weight(part.automaton for part in parts) if is_lap else 1
        self.choosing = [part for part in parts if not self.moves_together(part)]
        self.marks = NOTHING.union(*(part.marks for part in parts))

    @abstractmethod
    def moves_together(self, part: Part) -> bool:
        """Whether a part moves without a choice of the planner, in one action with others."""

    def problem(self) -> ClassicalProblem:
        """The whole classical problem."""
        undecided = [part for part in self.parts if len(part.states) != 1]
        starts = (*(part.start for part in undecided), ACT)
        states = {part.at(part.states[0]) for part in self.parts if len(part.states) == 1}
        init = self.all_facts(self.task.init) | {starts[0], BEFORE} | states
        goal, closing = self.closing()
        actions = (
            *self.starting(undecided, starts),
            *self.performing(),
            *self.reading(),
            *closing,
        )
        named = init.union(goal, *map(_named, actions))
        return ClassicalProblem(
            self.encoding,
            tuple(sorted(named)),
            init,
            goal,
            actions,
            frozenset({"actLoop"}),
        )

    def all_facts(self, facts: frozenset[Fluent]) -> frozenset[Fluent]:
        """The fluents that hold exactly if just these facts do."""
        return facts

    def starting(
        self, undecided: list[Part], tokens: tuple[Fluent, ...]
    ) -> Iterator[ClassicalAction]:
        """Choices of the first state, if the history leaves several; with none there is no plan."""
        for part, now, after in zip(undecided, tokens, tokens[1:], strict=False):
            for state in part.states:
                yield ClassicalAction(
                    f"startBA({part.number}, {state})",
                    requires=frozenset({now}),
                    adds=frozenset({after, part.at(state)}),
                    deletes=frozenset({now}),
                )

    def performing(self) -> Iterator[ClassicalAction]:
        """The actions of the task, for the prefix and for the loop."""
        after = self.turns()[0]
        for action, origin in zip(self.task.actions, self.task.origins, strict=True):
            plain = self.condition(
                ClassicalAction(
                    action.name,
                    requires=action.requires | {ACT},
                    forbids=action.forbids,
                    adds=action.adds,
                    deletes=action.deletes,
                    conditional=action.conditional,
                    cost=self.task.cost(action),
                    stands_for=origin,
                )
            )
            plain = passing(plain, ACT, after)
            yield replace(plain, requires=plain.requires | {BEFORE})
            yield replace(
                plain,
                name=f"loop {action.name}",
                requires=plain.requires | {LP_S},
                adds=plain.adds | {IN_LP},
                cost=plain.cost * self.weight,
            )

    def turns(self) -> tuple[Fluent, ...]:
        """The turns after an action: the parts read one after the other, then the vehicle acts."""
        return (*(part.turn for part in self.choosing), ACT)

    def reading(self) -> Iterator[ClassicalAction]:
        """The moves of the automata that the planner chooses."""
        tokens = self.turns()
        own = tokens[len(tokens) - 1 - len(self.choosing) :]
        for part, now, after in zip(self.choosing, own, own[1:], strict=False):
            for number, transition in enumerate(part.automaton.transitions):
                yield from self._choice(part, number, transition, now, after)

    def _choice(
        self, part: Part, number: int, transition: Transition, now: Fluent, after: Fluent
    ) -> Iterator[ClassicalAction]:
        """The actions for a transition; in the loop its marks are noted."""
        source, target = part.at(transition.source), part.at(transition.target)
        move = self.condition(
            ClassicalAction(
                f"mvBA({part.number}, {number})",
                requires=transition.label.positive | {now, source},
                forbids=transition.label.negative,
            )
        )
        move = replace(
            move,
            adds=frozenset({after, target}),
            deletes=frozenset({now}) | (frozenset({source}) - {target}),
        )
        if not transition.marks:
            yield move
            return
        yield replace(move, requires=move.requires | {BEFORE})
        yield replace(
            move,
            name=f"loop {move.name}",
            requires=move.requires | {LP_S},
            adds=move.adds.union(map(part.seen, transition.marks)),
        )

    def condition(self, action: ClassicalAction) -> ClassicalAction:
        """An action with the precondition and effects that the encoding gives it."""
        return action

    @abstractmethod
    def closing(self) -> tuple[frozenset[Fluent], list[ClassicalAction]]:
        """The goal, and the actions that remember where the loop begins and compare at its end."""

    def remembered(self) -> Iterator[tuple[Fluent, tuple[VariableValue, ...]]]:
        """The variables that a loop restores: a name, and the values.

        A fact that is alone either holds or not.
        """
        for facts in self.task.variables:
            values = [VariableValue(fact, True, f"req({fact})") for fact in facts]
            if len(facts) == 1:
                values.append(VariableValue(facts[0], False, f"req({complement(facts[0])})"))
            yield f"end({facts[0]})", tuple(values)
        for part in self.parts:
            if part.automaton.states > 1:
                states = range(part.automaton.states)
                yield part.end, tuple(VariableValue(part.at(z), True, part.req(z)) for z in states)


def passing(action: ClassicalAction, now: Fluent, after: Fluent) -> ClassicalAction:
    """An action that passes the turn on."""
    if now == after:
        return action
    return replace(action, adds=action.adds | {after}, deletes=action.deletes | {now})


def _named(action: ClassicalAction) -> frozenset[Fluent]:
    """All fluents that an action mentions."""
    names = action.requires | action.forbids | action.adds | action.deletes
    return names.union(*(e.requires | e.forbids | e.adds | e.deletes for e in action.conditional))
