"""Facts that product states need not remember: only one goal needs them, or nothing does.

A fact that stays true once it is made doubles the states: with photos of twelve trees there are
4,096 times as many states as places. A one-shot goal that is kept out of the product
(`one_shot_goals.py`) only waits until such a fact is made. If no action and no other conjunct reads
the fact, the same paths exist with it and without it. So a forgotten fact holds only at the states
that are entered by making it, where the goal is met.

Loops begin after all goals are met. There a forgotten fact would always hold, so a loop that closes
without it also closes with it.

A fact that no conjunct and no action reads is in no state at all, such as a photo that no line asks
for. A loop may make it in its first lap, which for the task is like all others.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

from companion.planning.builtin.fact_bits import FactBits
from companion.planning.builtin.masked_automaton import MaskedAutomaton
from companion.planning.builtin.transition_system import TransitionSystem


def unread_facts(system: TransitionSystem, readers: Counter[str], bits: FactBits) -> int:
    """The facts (bits) that nothing reads.

    Args:
        system: the transition system under the product.
        readers: the number of conjuncts that read each proposition.
        bits: the bits of the facts.
    """
    return system.only_made(system.changing & ~bits.mask(readers))


def forgotten_facts(
    system: TransitionSystem,
    goals: Sequence[tuple[MaskedAutomaton, int]],
    readers: Counter[str],
    bits: FactBits,
) -> int:
    """The facts (bits) that hold only right after they are made.

    Args:
        system: the transition system under the product.
        goals: the goals that are kept out of the product, each with the state in which it waits.
        readers: the number of conjuncts that read each proposition.
        bits: the bits of the facts.
    """
    awaited = 0
    for goal, pending in goals:
        awaited |= goal.awaited(pending)
    read_once = bits.mask([name for name, count in readers.items() if count == 1])
    return system.only_made(awaited & read_once)
