"""Routes on a map that does not change, with a cache of the distances between places.

A table of contingencies needs the same routes again and again, each time without another place.
"""

from __future__ import annotations

from typing import Any

from companion.geometry import Ned
from companion.motion.layered_routes import LayeredRoutes
from companion.motion.passage import Passage


class RememberedRoutes(LayeredRoutes):
    """Routes with a cache; neither their map nor their room may be changed.

    Args:
        options: the options of all routes.
    """

    def __init__(self, *options: Any, **more: Any) -> None:
        super().__init__(*options, **more)
        self._passages: dict[tuple[Ned, str, Ned], Passage] = {}
        self._connected: dict[tuple[Ned, str, Ned], bool] = {}

    def passage(self, start: Ned, place: str) -> Passage:
        """The quickest route to a place."""
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
