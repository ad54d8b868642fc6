"""Which optional lines of the task the present plan keeps."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from dataclasses import dataclass, replace


@dataclass(frozen=True, slots=True)
class LineChoice:
    """Optional lines by name.

    >>> choice = LineChoice(frozenset({"often", "calm"})).dropping(["calm"])
    >>> choice.kept(["first", "often", "calm"]), choice.after_skill.may_take_up
    (('often',), True)

    Attributes:
        optional: lines of the task that may be dropped.
        dropped: those that the present plan does not keep.
        may_take_up: whether a skill was completed since dropped lines were last reconsidered.
    """

    optional: frozenset[str]
    dropped: frozenset[str] = frozenset()
    may_take_up: bool = False

    def required(self, lines: Iterable[str]) -> tuple[str, ...]:
        """Those of these lines that must hold."""
        return tuple(line for line in lines if line not in self.optional)

    def kept(self, lines: Iterable[str]) -> tuple[str, ...]:
        """Those of these lines that may be dropped but are kept."""
        kept = self.optional - self.dropped
        return tuple(line for line in lines if line in kept)

    def dropping(self, lines: Collection[str]) -> LineChoice:
        """A plan is adopted that drops these lines and keeps all others."""
        return replace(self, dropped=frozenset(lines), may_take_up=False)

    @property
    def after_skill(self) -> LineChoice:
        """A skill was completed: dropped lines are reconsidered, if there are any."""
        return replace(self, may_take_up=bool(self.dropped))

    @property
    def reconsidered(self) -> LineChoice:
        """All dropped lines stay dropped until a skill is completed."""
        return replace(self, may_take_up=False)
