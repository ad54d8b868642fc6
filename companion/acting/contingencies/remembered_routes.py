"""Routes on a map that does not change: how far it is from place to place is found once.

A table of contingencies asks for the same ways again and again, with one place less each time.
"""

from __future__ import annotations

from typing import Any

from companion.geometry import Ned
from companion.motion.layered_routes import LayeredRoutes
from companion.motion.passage import Passage


class RememberedRoutes(LayeredRoutes):
    """Routes that remember; nobody may show them another map, or take room from them.

    Args:
        options: those of all routes.
    """

    def __init__(self, *options: Any, **more: Any) -> None:
        super().__init__(*options, **more)
        self._passages: dict[tuple[Ned, str, Ned], Passage] = {}
        self._connected: dict[tuple[Ned, str, Ned], bool] = {}

    def passage(self, start: Ned, place: str) -> Passage:
        """The quickest way to a place."""
        if not self.knows(place):
            return super().passage(start, place)
        key = start, place, self.goal(place)
        if key not in self._passages:
            self._passages[key] = super().passage(start, place)
        return self._passages[key]

    def is_connected(self, start: Ned, place: str) -> bool:
        """Whether free cells lead to a place."""
        if not self.knows(place):
            return super().is_connected(start, place)
        key = start, place, self.goal(place)
        if key not in self._connected:
            self._connected[key] = super().is_connected(start, place)
        return self._connected[key]
