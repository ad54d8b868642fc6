"""What a flight has learnt of its skills by trying them, as far as plans depend on it."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, replace

from companion.planning.domain import Action


@dataclass(frozen=True, slots=True)
class OverdueSkill:
    """A skill that works longer than its cost.

    Attributes:
        name: the skill, with `*` for the place from which it flies.
        least_ms: how long it takes at least.
    """

    name: str
    least_ms: int

    def lengthened(self, action: Action) -> Action:
        """The action; if it is this skill, with the cost that is known now."""
        is_own = action.skill == self.name.partition("(")[0] and action.from_anywhere == self.name
        return replace(action, cost_ms=max(action.cost_ms, self.least_ms)) if is_own else action


@dataclass(frozen=True, slots=True)
class SkillTrials:
    """Skills by name, with `*` for the place from which they fly.

    >>> from companion.planning.domain import reach
    >>> overdue = OverdueSkill("reach(*, A)", least_ms=9000)
    >>> longer, = SkillTrials(overdue=overdue).usable((reach("A"),))
    >>> longer.cost_ms, SkillTrials(barred=frozenset({"reach(*, A)"})).usable((reach("A"),))
    (9000, ())

    Attributes:
        barred: nobody knows whether they were done, so no plan does them again.
        put_aside: they failed several times in a row, so no plan has them until something changes.
        overdue: the skill that works longer than its cost, if one does.
    """

    barred: frozenset[str] = frozenset()
    put_aside: frozenset[str] = frozenset()
    overdue: OverdueSkill | None = None

    def usable(self, actions: tuple[Action, ...]) -> tuple[Action, ...]:
        """The actions that plans may contain, with what they cost as far as is known."""
        left_out = self.barred | self.put_aside
        if left_out:
            skills = {name.partition("(")[0] for name in left_out}
            actions = tuple(
                a for a in actions if a.skill not in skills or a.from_anywhere not in left_out
            )
        if self.overdue is None:
            return actions
        return tuple(map(self.overdue.lengthened, actions))

    def without(self, action: Action) -> SkillTrials:
        """A skill is barred."""
        return replace(self, barred=self.barred | {action.from_anywhere})

    def putting_aside(self, skills: Collection[str]) -> SkillTrials:
        """These skills have failed several times in a row, too."""
        return replace(self, put_aside=self.put_aside.union(skills))

    @property
    def with_all_put_back(self) -> SkillTrials:
        """Something has changed: what was put aside may be tried again."""
        return replace(self, put_aside=frozenset())

    @property
    def in_time(self) -> SkillTrials:
        """No skill is overdue, or the one that was has been completed."""
        return replace(self, overdue=None)


UNTRIED = SkillTrials()
"""Nothing has been learnt yet."""
