"""Turns a plan of a classical problem into the lasso that it stands for.

The automata's moves and the auxiliary actions are removed. The actions before the loop action are
the prefix, those after it the loop. `planning/check.py` decides whether the lasso is correct.
"""

from __future__ import annotations

from collections.abc import Sequence

from companion.errors import CompanionError
from companion.planning.compilation.classical import ClassicalProblem
from companion.planning.lasso import Lasso


def decode(classical: ClassicalProblem, names: Sequence[str]) -> Lasso:
    """The lasso of a plan.

    Args:
        classical: the problem that was solved.
        names: the actions of the plan, as the classical problem names them.

    Raises:
        CompanionError: the plan has an unknown action, no loop, several loops, or an empty loop.
    """
    known = {action.name: action for action in classical.actions}
    unknown = next((name for name in names if name not in known), None)
    if unknown is not None:
        raise CompanionError(f"the plan has an action that the problem has not: {unknown}")
    cuts = [index for index, name in enumerate(names) if name in classical.loops]
    if len(cuts) != 1:
        raise CompanionError(f"the plan begins {len(cuts)} loops, not one: {', '.join(names)}")
    prefix, loop = (
        tuple(action for name in part if (action := known[name].stands_for) is not None)
        for part in (names[: cuts[0]], names[cuts[0] :])
    )
    if not loop:
        raise CompanionError(f"the loop of the plan is empty: {', '.join(names)}")
    return Lasso(prefix, loop)
