"""How far is it to each site from everywhere, on the map as it is known now?

Each site has its field (`fields.py`). It is found when it is first asked for; when it is asked for
after a change of the map, it is repaired, from the state in which it was left. With many sites
that takes a while; `find` does it in small parts.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import numpy.typing as npt

from companion.motion.fields import Field, repaired, searched
from companion.motion.moves import Moves, all_of, moves_between, moves_entering
from companion.motion.regions import Regions
from companion.motion.sight import Points

_LEAST = 2000  # cells: a repair takes as long as a search of so many, however few it searches


class Approaches:
    """The fields of all sites.

    Args:
        goals: by site, (2,) where the ways to it end (`sight.py`).
        regions: no way enters one of these, but for the site's own.
        free: (rows, cols) the free cells at first.
    """

    def __init__(
        self, goals: Mapping[str, Points], regions: Regions, free: npt.NDArray[np.bool_]
    ) -> None:
        self._goals = dict(goals)
        self._regions = regions
        discs = zip(regions.names, regions.centres, regions.radii, strict=True)
        self._entering = {name: moves_entering(free.shape, *disc) for name, *disc in discs}
        self._barred: dict[str, Moves] = {}
        self._left: dict[str, Field] = {}
        self.see(free)

    def see(self, free: npt.NDArray[np.bool_]) -> None:
        """The free cells from now on, on the same map."""
        self._free = free
        self._moves: Moves | None = None  # found when a field is asked for
        self._fields: dict[str, Field | None] = {}

    def aim(self, site: str, goal: Points) -> None:
        """The ways to a site end here from now on."""
        self._goals[site] = goal
        self._fields.pop(site, None)
        self._left.pop(site, None)

    def find(self, cells: int) -> bool:
        """Finds fields until about so many cells are searched; whether all are found."""
        for site in self._goals:
            if site not in self._fields:
                if cells <= 0:
                    return False
                field = self.field(site)
                cells -= max(field.searched, _LEAST) if field else 0
        return True

    def field(self, site: str) -> Field | None:
        """The field of a site; None if the site cannot be reached from its own cell.

        Raises:
            KeyError: there is no such site.
        """
        if site not in self._fields:
            self._fields[site] = self._found(site)
        return self._fields[site]

    def _found(self, site: str) -> Field | None:
        goal = self._goals[site]
        row, col = np.floor(goal).astype(int).tolist()
        rows, cols = self._free.shape
        if not (0 <= row < rows and 0 <= col < cols and self._free[row, col]):
            return None
        centre = np.array((row + 0.5, col + 0.5))
        if self._regions.without(site).are_entered(centre, goal):
            return None
        moves = self._allowed(site)
        left = self._left.get(site)
        field = repaired(left, moves) if left else searched(moves, (row, col))
        self._left[site] = field
        return field

    def _allowed(self, site: str) -> Moves:
        """The moves on the map that a way to a site may use."""
        self._moves = self._moves or moves_between(self._free)
        if site not in self._barred:
            others = (moves for name, moves in self._entering.items() if name != site)
            self._barred[site] = all_of(others, self._free.shape)
        return self._moves.without(self._barred[site])
