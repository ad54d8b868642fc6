"""The symbol database: which waypoint each place stands for now (Section IV-D of the paper).

A place of the mission is a region. The waypoint in it that stands for the symbol is chosen late.
The first one is written in the mission. If it cannot be flown to, `SUGGESTERS` propose other
waypoints of the region, and the first one that passes all `TESTS` is taken.

Users can extend both tables: a place's own suggesters are asked before samples are taken, and its
own tests after ours (`place_functions.py`). These take time, so they are called only when a flight
to the place is about to begin, and not when the map has changed.

Each value has a source and a time. A waypoint to which a flight has failed is not proposed again
for a while.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import islice
from typing import Protocol

from companion.geometry import Ned, distance
from companion.mission.places import Place
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
ASKED_AT_ONCE = 8
"""The most waypoints in one call of a user's test, after a call with the first one."""
_CANDIDATE_US, _ROOM_US = 60, 30


@dataclass(frozen=True, slots=True)
class Value:
    """What a symbol stands for, its source, and its time."""

    position: Ned
    source: str
    stamp_s: float


def as_it_is(place: Place, value: Value) -> Iterator[Ned]:
    """The present waypoint."""
    yield value.position


def as_told(place: Place, value: Value) -> Iterator[Ned]:
    """The waypoint that the mission gives."""
    yield place.position


def around(place: Place, value: Value) -> Iterator[Ned]:
    """Samples spread evenly over the region, from its middle outwards."""
    return place.region.waypoints(place.position, SAMPLES, INSIDE_M)


Suggester = Callable[[Place, Value], Iterator[Ned]]
SUGGESTERS: Mapping[str, Suggester] = {"as it is": as_it_is, "the mission": as_told}
"""Source -> its suggester, in the order of asking; the place's own ones come next."""
AT_LAST: Mapping[str, Suggester] = {"samples of the region": around}
"""These are asked only if no other suggester has proposed a suitable waypoint."""


def is_free(routes: LayeredRoutes, name: str, waypoint: Ned, start: Ned) -> bool:
    """Whether the waypoint has the clearance on the present map, and lies inside the fence."""
    return routes.is_free(waypoint)


def is_reachable(routes: LayeredRoutes, name: str, waypoint: Ned, start: Ned) -> bool:
    """Whether a route leads there; it is searched in parts, if free cells lead there at all."""
    routes.aim(name, waypoint)
    if not routes.is_connected(start, name):
        return False
    while not routes.search(start, name, CELLS_PER_TICK):
        spent(CELL_US * CELLS_PER_TICK)
        routes.aim(name, waypoint)  # another choice may have been made meanwhile
    return math.isfinite(routes.distance_m(start, name))


TESTS: tuple[Callable[[LayeredRoutes, str, Ned, Ned], bool], ...] = (is_free, is_reachable)
"""What a waypoint has to pass: routes, symbol, waypoint, position of the vehicle."""


class PlaceAdvice(Protocol):
    """A place's own suggesters and tests."""

    def suggested(self, place: Place) -> Iterator[tuple[Ned, str]]:
        """Waypoints of its region, each with the name of its suggester."""

    def passing(self, place: Place, waypoints: Sequence[Ned]) -> list[bool]:
        """Whether each waypoint passes all tests."""


class Symbols:
    """The database: what each place stands for now.

    Args:
        places: the mission's places.
        routes: the routes, which lead to the present waypoint of each symbol.
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

    def find(self, name: str) -> Place | None:
        """The place with a name; None if there is none."""
        return self._places.get(name)

    def up_m(self, name: str | None) -> float | None:
        """Altitude of a place above home; None if it is not a place."""
        place = self._places.get(name or "")
        return -place.position[2] if place is not None else None

    def heading_rad(self, name: str) -> float | None:
        """The heading on arrival at any waypoint of a place; None for any heading."""
        return self._places[name].heading_rad

    def inner_m(self, name: str) -> float:
        """Radius of the largest disc around a place that its region contains."""
        return self._places[name].inner_m

    def suggest(self, name: str, position: Ned, source: str, now_s: float) -> None:
        """Takes the position of a place in its region from another program."""
        self._values[name] = Value(position, source, now_s)

    def refuse(self, name: str, now_s: float) -> None:
        """Notes that a flight to the present waypoint has failed."""
        value = self._values[name]
        self._refused[name].append(Value(value.position, value.source, now_s))

    def ground(
        self, name: str, start: Ned, now_s: float, advice: PlaceAdvice | None = None
    ) -> bool:
        """Chooses the waypoint of a symbol; False if none is possible, and the present one stays.

        On a large map it takes long. Until the choice is made, routes to the place may lead to a
        waypoint that is only being tried.

        Args:
            name: name of the place.
            start: where the vehicle is.
            now_s: time of the choice.
            advice: the place's own suggesters and tests; None to ignore them, if nothing can wait
                for them.
        """
        place, before = self._places[name], self._values[name]
        refused = [v.position for v in self._refused[name] if now_s - v.stamp_s < REFUSED_S]
        candidates = self._candidates(name, start, refused, advice)
        try:
            if advice is None or not place.tests:
                chosen = next(candidates, None)
            else:
                chosen = _passing(place, candidates, advice)
            if chosen is not None and chosen[0] != before.position:
                self._values[name] = Value(*chosen, now_s)
            return chosen is not None
        finally:  # whether a choice was made or given up
            self._routes.aim(name, self._values[name].position)

    def _candidates(
        self, name: str, start: Ned, refused: Sequence[Ned], advice: PlaceAdvice | None
    ) -> Iterator[tuple[Ned, str]]:
        """Waypoints that pass our tests, each with its source."""
        for waypoint, source in self._suggested(name, advice):
            if any(distance(waypoint, other) < SAME_M for other in refused):
                continue
            spent(_CANDIDATE_US)
            if all(passes(self._routes, name, waypoint, start) for passes in TESTS):
                yield waypoint, source

    def _suggested(self, name: str, advice: PlaceAdvice | None) -> Iterator[tuple[Ned, str]]:
        """Waypoints of a symbol, each with its source."""
        place, value = self._places[name], self._values[name]
        if place.found_by:  # the place is exactly where it was found
            yield value.position, value.source
            return
        for source, suggest in SUGGESTERS.items():
            for waypoint in suggest(place, value):
                yield waypoint, source
        if advice is not None:
            yield from advice.suggested(place)
        for source, suggest in AT_LAST.items():
            for waypoint in self._roomiest_first(suggest(place, value)):
                yield waypoint, source

    def _roomiest_first(self, waypoints: Iterator[Ned]) -> Sequence[Ned]:
        """The waypoints, beginning with those that keep the full clearance of routes."""
        routes, kept_m = self._routes, self._routes.kept_m

        def room_m(waypoint: Ned) -> float:
            spent(_ROOM_US)
            plane = routes.plane(-waypoint[2])
            away_m = plane.obstacles.clearance_m(waypoint[:2]) if plane is not None else kept_m
            return min(kept_m, away_m)

        return sorted(waypoints, key=room_m, reverse=True)

    def follow_map(self, start: Ned, now_s: float) -> list[str]:
        """Chooses again if the map has blocked a waypoint or its route; returns what moved."""
        moved = []
        for name, value in list(self._values.items()):
            if self._routes.knows(name) and not self._routes.is_connected(start, name):
                self.ground(name, start, now_s)
                if self._values[name] is not value:
                    moved.append(name)
        return moved


def _passing(
    place: Place, candidates: Iterator[tuple[Ned, str]], advice: PlaceAdvice
) -> tuple[Ned, str] | None:
    """The first candidate that passes the place's own tests; None if none does."""
    asked: set[Ned] = set()
    fresh = (each for each in candidates if each[0] not in asked)
    count = 1
    while batch := list(islice(fresh, count)):
        verdicts = advice.passing(place, [waypoint for waypoint, _ in batch])
        for candidate, passes in zip(batch, verdicts, strict=True):
            if passes:
                return candidate
        asked |= {waypoint for waypoint, _ in batch}
        count = ASKED_AT_ONCE
    return None
