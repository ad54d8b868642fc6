"""The symbol database: which waypoint each place stands for now (Section IV-D of the paper).

A place of the mission is a region; the waypoint in it that stands for the symbol is chosen late.
People have written the first one, the mission's; algorithms write others when it cannot be flown
to: `SUGGESTERS` propose waypoints of the region, and the first that passes all `TESTS` is taken.
Each value has its source and its time. A waypoint to which a flight has failed is not proposed
again for a while.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass

from companion.geometry import Ned, distance
from companion.mission.model import Place
from companion.motion.distance_maps import CELL_US
from companion.motion.layered_routes import LayeredRoutes
from companion.motion.routes import CELLS_PER_TICK
from companion.slices import spent

SAMPLES = 48
INSIDE_M = 0.3
"""Samples keep this far inside the region, so that the vehicle arrives in it."""
REFUSED_S = 60.0
SAME_M = 0.2
"""Waypoints nearer to each other are the same."""
_CANDIDATE_US = 60


@dataclass(frozen=True, slots=True)
class Value:
    """What a symbol stands for, who says so, and since when."""

    position: Ned
    source: str
    stamp_s: float


def as_it_is(place: Place, value: Value) -> Iterator[Ned]:
    """The present waypoint."""
    yield value.position


def as_told(place: Place, value: Value) -> Iterator[Ned]:
    """The waypoint that the mission says."""
    yield place.position


def around(place: Place, value: Value) -> Iterator[Ned]:
    """Samples spread evenly over the region, from its middle outwards."""
    return place.region.waypoints(place.position, SAMPLES, INSIDE_M)


SUGGESTERS: Mapping[str, Callable[[Place, Value], Iterator[Ned]]] = {
    "as it is": as_it_is,
    "the mission": as_told,
    "samples of the region": around,
}
"""Source -> what it proposes, in the order in which they are asked."""


def is_free(routes: LayeredRoutes, name: str, waypoint: Ned, start: Ned) -> bool:
    """It has the clearance on the map as it is known now, and lies inside the fence."""
    return routes.is_free(waypoint)


def is_reachable(routes: LayeredRoutes, name: str, waypoint: Ned, start: Ned) -> bool:
    """A way leads there; it is searched in parts."""
    routes.aim(name, waypoint)
    while not routes.search(start, name, CELLS_PER_TICK):
        spent(CELL_US * CELLS_PER_TICK)
        routes.aim(name, waypoint)  # others may have chosen meanwhile
    return math.isfinite(routes.distance_m(start, name))


TESTS: tuple[Callable[[LayeredRoutes, str, Ned, Ned], bool], ...] = (is_free, is_reachable)
"""What a waypoint has to pass: routes, symbol, waypoint, where the vehicle is."""


class Symbols:
    """The database: what each place stands for now.

    Args:
        places: of the mission.
        routes: lead to the waypoint that a symbol has now.
    """

    def __init__(self, places: Mapping[str, Place], routes: LayeredRoutes) -> None:
        self._places = places
        self._routes = routes
        self._values = {name: Value(p.position, "the mission", 0.0) for name, p in places.items()}
        self._refused: dict[str, list[Value]] = {name: [] for name in places}

    def __getitem__(self, name: str) -> Value:
        """The present value of a symbol."""
        return self._values[name]

    def place(self, name: str) -> Place:
        """A place as the mission has it."""
        return self._places[name]

    def up_m(self, name: str | None) -> float | None:
        """Altitude of a place above home; None of what is no place."""
        place = self._places.get(name or "")
        return -place.position[2] if place is not None else None

    def heading_rad(self, name: str) -> float | None:
        """With what heading the vehicle arrives, at whatever waypoint; None for any."""
        return self._places[name].heading_rad

    def inner_m(self, name: str) -> float:
        """Radius of the disc about a place that its region holds."""
        return self._places[name].inner_m

    def refuse(self, name: str, now_s: float) -> None:
        """A flight to the present waypoint has failed."""
        value = self._values[name]
        self._refused[name].append(Value(value.position, value.source, now_s))

    def ground(self, name: str, start: Ned, now_s: float) -> bool:
        """Choose the waypoint of a symbol; False if none can be flown to, and it stays.

        It takes long on a large map. Until the choice is made routes to the place may lead to a
        waypoint that is only tried.

        Args:
            name: of the place.
            start: where the vehicle is.
            now_s: time of the choice.
        """
        before = self._values[name]
        refused = [v.position for v in self._refused[name] if now_s - v.stamp_s < REFUSED_S]
        try:
            for waypoint, source in self._suggested(name):
                if any(distance(waypoint, other) < SAME_M for other in refused):
                    continue
                spent(_CANDIDATE_US)
                if all(passes(self._routes, name, waypoint, start) for passes in TESTS):
                    if waypoint != before.position:
                        self._values[name] = Value(waypoint, source, now_s)
                    return True
            return False
        finally:  # whether it is made or given up
            self._routes.aim(name, self._values[name].position)

    def _suggested(self, name: str) -> Iterator[tuple[Ned, str]]:
        """Waypoints of a symbol, and who proposes them."""
        place, value = self._places[name], self._values[name]
        for source, suggest in SUGGESTERS.items():
            for waypoint in suggest(place, value):
                yield waypoint, source

    def follow_map(self, start: Ned, now_s: float) -> list[str]:
        """Choose anew where the map has taken a waypoint away, or the way to it; what moved."""
        moved = []
        for name, value in list(self._values.items()):
            if not self._routes.is_connected(start, name):
                self.ground(name, start, now_s)
                if self._values[name] is not value:
                    moved.append(name)
        return moved
