"""Which fences and rally points of an autopilot are this companion's own, from earlier flights too.

They stay in the autopilot after the flight. The next mission may put its own in their place, since
nobody else has drawn them. What a user has drawn is never taken for ours: it would have to be the
same within centimetres.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

from companion.mavlink.plan_transfer import PlanItem

UploadedItems = tuple[PlanItem, ...]

MOST_UPLOADS = 16
"""The newest ones are remembered: of missions, and of vehicles that take turns."""


class OwnItems:
    """What was written of one kind, oldest first.

    Args:
        written: in other flights.
        keep: told of all of them when there is a new one.

    Attributes:
        in_force: the items of which it is known that they are in force; None if nothing is.
    """

    def __init__(
        self,
        written: Sequence[UploadedItems] = (),
        keep: Callable[[Sequence[UploadedItems]], None] = lambda _: None,
    ) -> None:
        self.in_force: UploadedItems | None = None
        self._written = list(written)
        self._keep = keep

    @property
    def written(self) -> tuple[UploadedItems, ...]:
        """All that are remembered."""
        return tuple(self._written)

    def note(self, items: UploadedItems) -> None:
        """Some are about to be written; until more is known nothing is in force."""
        self.in_force = None
        if not items:
            return
        self._written = [each for each in self._written if each != items][1 - MOST_UPLOADS :]
        self._written.append(items)
        self._keep(self._written)
