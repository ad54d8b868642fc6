"""Encoding v4: one automaton for each conjunct, with conditional effects.

All deterministic automata move in one action. A state is deleted only when it is left. If a letter
has no transition, the flag deadBA stops everything: otherwise the automaton would stay in its
state, and so accept what it should reject.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

from companion.ltl.automaton import Label
from companion.planning.compilation.classical import ClassicalAction, Fluent
from companion.planning.compilation.decomposed import (
    ACT,
    BEFORE,
    END_DONE,
    IN_LP,
    LP_S,
    NOTHING,
    DecomposedEncoding,
    Part,
    passing,
)
from companion.planning.domain import ConditionalEffect
from companion.planning.objective import Encoding

DEAD = "deadBA"
READ_ALL = "BAturn"


class ConditionalEncoding(DecomposedEncoding):
    """Encoding v4."""

    encoding = Encoding.V4

    def moves_together(self, part: Part) -> bool:
        """Whether the automaton is deterministic."""
        return part.is_deterministic

    @property
    def together(self) -> list[Part]:
        """The parts that move together in one action."""
        return [part for part in self.parts if self.moves_together(part)]

    def turns(self) -> tuple[Fluent, ...]:
        """The turns of all parts; parts that move together come first, in one turn."""
        return (READ_ALL, *super().turns()) if self.together else super().turns()

    def condition(self, action: ClassicalAction) -> ClassicalAction:
        """The action, forbidden after a letter that some automaton cannot read."""
        return replace(action, forbids=action.forbids | {DEAD})

    def reading(self) -> Iterator[ClassicalAction]:
        """One move of all deterministic automata, and the choices for the others."""
        if self.together:
            effects = tuple(e for part in self.together for e in _moves_of(part))
            move = ClassicalAction("mvBA", requires=frozenset({READ_ALL}), conditional=effects)
            yield passing(move, READ_ALL, self.turns()[1])
        yield from super().reading()

    def closing(self) -> tuple[frozenset[Fluent], list[ClassicalAction]]:
        """One action that remembers everything, and one that compares everything."""
        begin, end, ends = [], [], set()
        for name, values in self.remembered():
            ends.add(name)
            for value in values:
                this = frozenset({value.fluent})
                requires, forbids = (this, NOTHING) if value.holds else (NOTHING, this)
                begin.append(_when(requires, forbids, value.memory))
                end.append(_when(requires | {value.memory}, forbids, name))
        loop = ClassicalAction(
            "actLoop",
            requires=frozenset({ACT, BEFORE}),
            adds=frozenset({LP_S}),
            deletes=frozenset({BEFORE}),
            conditional=tuple(begin),
        )
        close = ClassicalAction(
            "actEnd",
            requires=self.marks | {ACT, IN_LP},
            adds=frozenset({END_DONE}),
            deletes=frozenset({ACT}),
            conditional=tuple(end),
        )
        return frozenset({END_DONE, *ends}), [self.condition(loop), self.condition(close)]


def _moves_of(part: Part) -> Iterator[ConditionalEffect[Fluent]]:
    """The moves of a deterministic automaton; only a state that is left is deleted."""
    for state, leaving in enumerate(part.automaton.outgoing):
        here = frozenset({part.at(state)})
        for transition in leaving:
            requires, forbids = transition.label.positive | here, transition.label.negative
            if transition.target != state:
                there = frozenset({part.at(transition.target)})
                yield ConditionalEffect(requires, forbids, there, here)
            if transition.marks:
                seen = frozenset(map(part.seen, transition.marks))
                yield ConditionalEffect(requires | {LP_S}, forbids, seen, NOTHING)
        for label in unread([transition.label for transition in leaving]):
            yield _when(label.positive | here, label.negative, DEAD)


def unread(labels: Sequence[Label]) -> list[Label]:
    """Disjoint labels that match exactly the letters that no given label matches."""
    found = []
    pending = [(Label(NOTHING, NOTHING), list(labels))]
    while pending:
        chosen, left = pending.pop()
        if not left:
            found.append(chosen)
            continue
        literals = left[0].positive | left[0].negative
        if literals:
            split = frozenset({min(literals)})
            pending += [
                (
                    Label(chosen.positive | split, chosen.negative),
                    [Label(x.positive - split, x.negative) for x in left if not split & x.negative],
                ),
                (
                    Label(chosen.positive, chosen.negative | split),
                    [Label(x.positive, x.negative - split) for x in left if not split & x.positive],
                ),
            ]
    return found


def _when(
    requires: frozenset[Fluent], forbids: frozenset[Fluent], added: Fluent
) -> ConditionalEffect[Fluent]:
    return ConditionalEffect(requires, forbids, frozenset({added}), NOTHING)
