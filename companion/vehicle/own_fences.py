"""Which fences of an autopilot are this companion's own, and which of them is known to be in force.

A fence stays in the autopilot after the flight. The next mission may put its own in that one's
place, since nobody else has drawn it. What a user has drawn is never taken for ours: it would have
to be the same within centimetres.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

from companion.mavlink.plan_transfer import PlanItem

FenceItems = tuple[PlanItem, ...]

MOST_FENCES = 16
"""The newest ones are remembered: of missions, and of vehicles that take turns."""


class OwnFences:
    """The fences that were written, oldest first.

    Args:
        written: in other flights.
        keep: told of all of them when there is a new one.

    Attributes:
        in_force: the items of the one that is known to be in force; None if none is.
    """

    def __init__(
        self,
        written: Sequence[FenceItems] = (),
        keep: Callable[[Sequence[FenceItems]], None] = lambda _: None,
    ) -> None:
        self.in_force: FenceItems | None = None
        self._written = list(written)
        self._keep = keep

    @property
    def written(self) -> tuple[FenceItems, ...]:
        """All that are remembered."""
        return tuple(self._written)

    def note(self, items: FenceItems) -> None:
        """A fence is about to be written; until more is known none is in force."""
        self.in_force = None
        self._written = [each for each in self._written if each != items][1 - MOST_FENCES :]
        self._written.append(items)
        self._keep(self._written)
