"""Facts that the states of a product need not remember: they are made for one goal, or for none.

A fact that stays once it is made doubles the states: photos of twelve trees make 4,096 times as
many as there are places. A one-shot goal that is kept out of the product (`one_shot_goals.py`)
waits for such a fact only to be made. If nothing else reads it, neither an action nor another
conjunct, the same paths are open with it and without it. So a forgotten fact holds only at the
states that are entered by making it, where the goal is met.

Loops begin after all goals are met. There a forgotten fact holds for good, whatever a loop does, so
a loop that closes without it closes with it.

A fact that neither a conjunct nor an action reads is in no state at all, such as a photo that no
line asks for. A loop may make it in its first lap, which to the task is as all others.
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
        system: under the product.
        readers: how many conjuncts read each proposition.
        bits: of the facts.
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
        system: under the product.
        goals: that are kept out of the product, each with the state in which it waits.
        readers: how many conjuncts read each proposition.
        bits: of the facts.
    """
    awaited = 0
    for goal, pending in goals:
        awaited |= goal.awaited(pending)
    read_once = bits.mask([name for name, count in readers.items() if count == 1])
    return system.only_made(awaited & read_once)
