"""The classical planning problem: propositional fluents, and actions over them with costs.

Encodings make it (`paper.py`, `decomposed.py`), `pddl.py` writes it, `engines.py` lets a planner
solve it, and `decode.py` turns a plan for it back into a lasso. This module knows of no planner.
"""

from __future__ import annotations

from dataclasses import dataclass

from companion.planning.domain import Action, ConditionalEffect
from companion.planning.objective import Encoding

Fluent = str
"""A fact of the task, in the task's spelling, or an auxiliary fluent such as "currBA(2)"."""


@dataclass(frozen=True, slots=True)
class ClassicalAction:
    """One action of the classical problem.

    Attributes:
        cost: in the problem's units; 0 for auxiliary actions.
        stands_for: the task's action that it performs; None for auxiliary actions.
    """

    name: str
    requires: frozenset[Fluent] = frozenset()
    forbids: frozenset[Fluent] = frozenset()
    adds: frozenset[Fluent] = frozenset()
    deletes: frozenset[Fluent] = frozenset()
    conditional: tuple[ConditionalEffect[Fluent], ...] = ()
    cost: int = 0
    stands_for: Action | None = None

    def is_applicable(self, state: frozenset[Fluent]) -> bool:
        """Whether the precondition holds."""
        return self.requires <= state and not self.forbids & state

    def apply(self, state: frozenset[Fluent]) -> frozenset[Fluent]:
        """The state after the action; what it both adds and deletes is added, as in PDDL."""
        met = [effect for effect in self.conditional if effect.is_met(state)]
        deletes = self.deletes.union(*(effect.deletes for effect in met))
        return (state - deletes).union(self.adds, *(effect.adds for effect in met))


@dataclass(frozen=True)
class ClassicalProblem:
    """A classical planning problem; its goal is a set of fluents that have to hold.

    Attributes:
        loops: the auxiliary actions that begin the loop of the lasso.
    """

    encoding: Encoding
    fluents: tuple[Fluent, ...]
    init: frozenset[Fluent]
    goal: frozenset[Fluent]
    actions: tuple[ClassicalAction, ...]
    loops: frozenset[str]

    @property
    def has_conditional_effects(self) -> bool:
        """Whether a planner must support conditional effects to solve it."""
        return any(action.conditional for action in self.actions)
