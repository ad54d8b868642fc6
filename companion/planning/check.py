"""The independent check that every plan has to pass before it is flown.

It uses no automaton and no search. It checks three things:
1. Every action of the plan can be executed on the facts.
2. The loop closes, in its first or second lap, for all facts that the task or the plan reads.
3. Each conjunct holds on the word, by the direct semantics of LTL. The word includes the history,
   because a task is about the whole flight and not only about the rest of it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

from companion.ltl.semantics import holds
from companion.mission.facts import Fact
from companion.planning.domain import Action, ConditionalEffect
from companion.planning.lasso import Lasso, Letter, Problem, word
from companion.slices import spent

_ACTION_US = 5
_CONJUNCT_US = 5
_LETTER_US = 0.05


def fault(problem: Problem, lasso: Lasso, histories: Sequence[Sequence[Letter]]) -> str | None:
    """The fault of a plan, in words; None if it has none.

    Args:
        problem: the problem that the plan solves.
        lasso: the plan.
        histories: per conjunct, the letters that it has read, including the present position's.
    """
    if not lasso.loop:
        return "the loop is empty"
    read = _read(problem, lasso)
    problem = replace(problem, facts=problem.facts & read)
    lap = _lap(problem, lasso)
    if isinstance(lap, str):
        return lap
    if changed := (lap.begin ^ lap.end) & read:
        lasso = Lasso((*lasso.prefix, *lasso.loop), lasso.loop)  # now after one lap
        second = _lap(problem, lasso)
        if isinstance(second, str) or (second.begin ^ second.end) & read:
            return f"the loop does not close: {', '.join(sorted(changed))} changed"
    prefix, loop = word(problem, lasso)
    for conjunct, history in zip(problem.conjuncts, histories, strict=True):
        spent(_CONJUNCT_US + _LETTER_US * (len(history) + len(prefix) + len(loop)))
        if not holds(conjunct.formula, [*history, *prefix], loop):
            return f"the plan's word does not satisfy {conjunct.name}: {conjunct.formula}"
    return None


class _Lap(NamedTuple):
    """The facts before the first lap of a plan and after it."""

    begin: frozenset[Fact]
    end: frozenset[Fact]


def _lap(problem: Problem, lasso: Lasso) -> _Lap | str:
    """The first lap of a plan, or why it cannot be reached or flown."""
    facts = begin = problem.facts
    for i, action in enumerate((*lasso.prefix, *lasso.loop)):
        if i == len(lasso.prefix):
            begin = facts
        spent(_ACTION_US)
        if not action.is_applicable(facts):
            missing = sorted(action.requires - facts) + [f"not {f}" for f in action.forbids & facts]
            return f"{action.name} cannot be executed: {', '.join(missing)} does not hold"
        facts = action.apply(facts)
    return _Lap(begin, facts)


def _read(problem: Problem, lasso: Lasso) -> frozenset[Fact]:
    """The facts that the task or an action of the plan reads; the others do not matter."""
    read = {fact for conjunct in problem.conjuncts for fact in conjunct.facts}
    of_plan: list[Action | ConditionalEffect[Fact]] = [*lasso.prefix, *lasso.loop]
    of_plan += [effect for action in (*lasso.prefix, *lasso.loop) for effect in action.conditional]
    for each in of_plan:
        read |= each.requires | each.forbids
    return frozenset(read)
