"""Compilations with one automaton for each conjunct and generalized acceptance (v4, v5).

A single automaton for the whole task grows exponentially with the task, and its single acceptance
set fixes the order in which a lap meets the parts of the task. Here each conjunct keeps its own
small automaton, and a flag for each acceptance set says that the loop has met it, in any order.

Vehicle and automata take turns: the vehicle acts, the automata read the facts that hold then, the
vehicle acts. For a nondeterministic automaton the planner chooses each transition, and thereby one
run. So no set of states has to be tracked, and none has to be reduced to one state where the loop
begins. A word without a run leaves no transition to choose.

This module contains what both encodings share; `conditional.py` completes it to v4 and `strips.py`
to v5.
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
    """One automaton, restricted by the constants.

    Attributes:
        number: its index among the parts, for names.
        states: the states that it may be in.
    """

    number: int
    automaton: BuchiAutomaton
    states: tuple[int, ...]

    def at(self, state: int) -> Fluent:
        """The fluent that says: the automaton is in a state."""
        return f"currBA({self.number}, {state})"

    def req(self, state: int) -> Fluent:
        """The fluent that says: the loop begins in a state."""
        return f"reqLp({self.number}, {state})"

    def seen(self, mark: int) -> Fluent:
        """The fluent that says: the loop has met a mark."""
        return f"seenBA({self.number}, {mark})"

    @property
    def turn(self) -> Fluent:
        """The fluent that says: the automaton reads the facts next."""
        return f"BAturn({self.number})"

    @property
    def start(self) -> Fluent:
        """The fluent that says: its first state is chosen next."""
        return f"BAstart({self.number})"

    @property
    def end(self) -> Fluent:
        """The fluent that says: the automaton is where the loop began."""
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
        """The fluents that say: the loop has met all marks."""
        return frozenset(map(self.seen, range(self.automaton.marks)))


@dataclass(frozen=True, slots=True)
class VariableValue:
    """A value of a variable: a fluent holds, or it does not.

    Attributes:
        memory: the fluent that remembers the value at the beginning of the loop.
    """

    fluent: Fluent
    holds: bool
    memory: Fluent

    @property
    def positive(self) -> Fluent:
        """The fluent that holds for this value, if each fluent has a complement."""
        return self.fluent if self.holds else complement(self.fluent)


def complement(fluent: Fluent) -> Fluent:
    """The fluent that holds exactly if another one does not."""
    return f"not({fluent})"


def parts(problem: Problem, task: ReducedTask) -> Iterator[Part]:
    """The automata, restricted by the constants; those that accept everything are left out."""
    found = zip(problem.conjuncts, problem.automaton_states, strict=True)
    for number, (conjunct, whole) in enumerate(found):
        rest = restricted(conjunct.automaton, task.constants(conjunct.automaton.propositions))
        states = tuple(rest.states(whole))
        if rest.everything.isdisjoint(states):
            yield Part(number, rest.automaton, states)


class DecomposedEncoding(ABC):
    """What v4 and v5 share. One of the turn fluents holds at a time, and says whose turn it is."""

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
        """Whether a part moves in one action with others, without a choice of the planner."""

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
        """The fluents that hold exactly if these facts hold and no others."""
        return facts

    def starting(
        self, undecided: list[Part], tokens: tuple[Fluent, ...]
    ) -> Iterator[ClassicalAction]:
        """Choices of the first state, if the history leaves several; no plan if it leaves none."""
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
        """The actions for a transition; in the loop they note its marks."""
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
        """An action, with the precondition and effects that the encoding adds."""
        return action

    @abstractmethod
    def closing(self) -> tuple[frozenset[Fluent], list[ClassicalAction]]:
        """The goal, and the actions that store where the loop begins and compare at its end."""

    def remembered(self) -> Iterator[tuple[Fluent, tuple[VariableValue, ...]]]:
        """The variables that a loop has to restore: a name, and the values.

        A fact that is in no group has two values: it holds or not.
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
