"""Remembers which fences and rally points this companion wrote to autopilots, also in earlier
flights.

They stay in the autopilot after the flight. The next mission may replace them, since nobody else
has drawn them. What a user has drawn is never taken for ours: it would have to be equal within
centimetres.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

from companion.mavlink.item_transfer import StoredItem

UploadedItems = tuple[StoredItem, ...]

MOST_UPLOADS = 16
"""The newest ones are remembered: of several missions, and of vehicles that take turns."""


class OwnItems:
    """The uploads of one kind, oldest first.

    Args:
        written: those of other flights.
        keep: called with all of them when one is added.

    Attributes:
        in_force: the items known to be in force; None if none are.
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
        """Remembers items that are about to be written; until more is known, none are in force."""
        self.in_force = None
        if not items:
            return
        self._written = [each for each in self._written if each != items][1 - MOST_UPLOADS :]
        self._written.append(items)
        self._keep(self._written)
