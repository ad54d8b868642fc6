"""What a flight has learnt of its skills by trying them, as far as plans depend on it."""

from __future__ import annotations

from dataclasses import dataclass, replace

from companion.planning.domain import Action


@dataclass(frozen=True, slots=True)
class SkillTrials:
    """Skills by name, with `*` for the place from which they fly.

    >>> from companion.planning.domain import reach
    >>> lengthened, = SkillTrials(overdue="reach(*, A)", least_ms=9000).usable((reach("A"),))
    >>> lengthened.cost_ms, SkillTrials(barred=frozenset({"reach(*, A)"})).usable((reach("A"),))
    (9000, ())

    Attributes:
        barred: nobody knows whether they were done, so no plan does them again.
        put_aside: they failed several times in a row, so no plan has them until something changes.
        overdue: the skill that works longer than its cost; "" if none does.
        least_ms: how long that skill takes at least.
    """

    barred: frozenset[str] = frozenset()
    put_aside: frozenset[str] = frozenset()
    overdue: str = ""
    least_ms: int = 0

    def usable(self, actions: tuple[Action, ...]) -> tuple[Action, ...]:
        """The actions that plans may contain, with what they cost as far as is known."""
        left_out = self.barred | self.put_aside
        if left_out:
            skills = {name.partition("(")[0] for name in left_out}
            actions = tuple(
                a for a in actions if a.skill not in skills or a.from_anywhere not in left_out
            )
        return tuple(map(self._lengthened, actions)) if self.overdue else actions

    def without(self, action: Action) -> SkillTrials:
        """A skill is barred."""
        return replace(self, barred=self.barred | {action.from_anywhere})

    @property
    def forgiven(self) -> SkillTrials:
        """Something has changed: what was put aside may be tried again."""
        return replace(self, put_aside=frozenset())

    @property
    def in_time(self) -> SkillTrials:
        """A skill was completed: none is overdue any more."""
        return replace(self, overdue="", least_ms=0)

    def _lengthened(self, action: Action) -> Action:
        skill = self.overdue.partition("(")[0]
        is_own = action.skill == skill and action.from_anywhere == self.overdue
        return replace(action, cost_ms=max(action.cost_ms, self.least_ms)) if is_own else action


UNTRIED = SkillTrials()
"""Nothing has been learnt yet."""
