"""Encoding v5: one automaton for each conjunct, in plain STRIPS.

The planner chooses each transition of every automaton. The beginning of the loop is stored, and
compared at its end, one variable at a time. Each fact p has a complement not(p), so that no
condition is negative. Every classical planner can read this.
"""

from __future__ import annotations

from dataclasses import replace

from companion.errors import RequestError
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
    complement,
    passing,
)
from companion.planning.compilation.reduced_task import ReducedTask
from companion.planning.objective import Encoding, Objective


class StripsEncoding(DecomposedEncoding):
    """Encoding v5.

    Raises:
        CompanionError: the effect of a skill depends on a condition.
    """

    encoding = Encoding.V5

    def __init__(self, task: ReducedTask, parts: tuple[Part, ...], objective: Objective) -> None:
        super().__init__(task, parts, objective)
        if task.has_conditional_effects:
            name = next(action.name for action in task.actions if action.conditional)
            raise RequestError(
                f"encoding v5 has no conditional effects, but {name} has one; use v1 or v4"
            )
        alone = {facts[0] for facts in task.variables if len(facts) == 1}
        labels = [t.label for part in parts for t in part.automaton.transitions]
        self.complemented = alone.union(
            *(action.forbids for action in task.actions), *(label.negative for label in labels)
        )

    def moves_together(self, part: Part) -> bool:
        """Never: the planner chooses each transition."""
        return False

    def all_facts(self, facts: frozenset[Fluent]) -> frozenset[Fluent]:
        """The facts, with the complements of those that do not hold."""
        return facts | frozenset(map(complement, self.complemented - facts))

    def condition(self, action: ClassicalAction) -> ClassicalAction:
        """The action with complements instead of negations, and effects that maintain them."""
        gone, come = self.complemented & action.deletes, self.complemented & action.adds
        return replace(
            action,
            requires=action.requires.union(map(complement, action.forbids)),
            forbids=NOTHING,
            adds=action.adds.union(map(complement, gone)),
            deletes=action.deletes.union(map(complement, come)),
        )

    def closing(self) -> tuple[frozenset[Fluent], list[ClassicalAction]]:
        """For each value, an action that remembers it and one that compares it."""
        remembered = list(self.remembered())
        keeping = [f"keepLp({name})" for name, _ in remembered]
        matching = [f"matchLp({name})" for name, _ in remembered]
        loop = ClassicalAction(
            "actLoop", requires=frozenset({ACT, BEFORE}), deletes=frozenset({BEFORE})
        )
        close = ClassicalAction("actEnd", requires=self.marks | {ACT, IN_LP})
        actions = [
            passing(replace(loop, adds=frozenset({LP_S})), ACT, (*keeping, ACT)[0]),
            passing(close, ACT, (*matching, END_DONE)[0]),
        ]
        afterwards = zip((*keeping[1:], ACT), (*matching[1:], END_DONE), strict=True)
        for index, (after_keeping, after_matching) in enumerate(afterwards if remembered else ()):
            for value in remembered[index][1]:
                keep = ClassicalAction(
                    f"keep {value.positive}",
                    requires=frozenset({keeping[index], value.positive}),
                    adds=frozenset({value.memory}),
                )
                match = ClassicalAction(
                    f"match {value.positive}",
                    requires=frozenset({matching[index], value.positive, value.memory}),
                )
                actions.append(passing(keep, keeping[index], after_keeping))
                actions.append(passing(match, matching[index], after_matching))
        return frozenset({END_DONE}), actions
