"""Routes between places at different heights, among obstacles of which some are low.

A low wall is an obstacle unless the vehicle is at least the clearance above it. Which walls that
are depends only on the altitude. So for each set of low walls that can be flown over there is a
plane of routes (`routes.py`), made when it is first needed. There are three ways to fly from one
height to another:

- sloped: straight up or down along the whole route, around all that is not clear at the lower end;
- stepped: a climb on the spot first, or a descent on the spot last, and level flight in between,
  over the walls that are low enough for the higher end;
- over the top: a climb on the spot to the clearance above a wall that is higher than both ends, or
  almost, then level flight, then a descent on the spot; within the altitude band.

The quickest one is flown, and its time is its cost. If routes keep more than the least clearance,
those that keep as much above walls, too, come first; over the top, as much as the band allows. A
start from which no route leads away level, low above a roof or below the band, is left by a climb.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from companion.geometry import Ned, NorthEast
from companion.motion.grid import OccupancyGrid
from companion.motion.passage import LEVEL_M, Passage
from companion.motion.profile import SpeedLimits
from companion.motion.routes import PlaceRegion, Route, RouteMap

BELOW_M = 0.3
"""A vehicle so far below the band has not merely drifted there."""
MOST_TOPS = 3
"""The most altitudes above low walls at which routes are searched; each has a whole plane."""
LevelRoute = Callable[[Ned, str, float], Route | None]
"""A route from a point to a place at a given altitude (down)."""


class LayeredRoutes:
    """Routes to places in space, on the map as it is known now.

    Attributes:
        version: changes whenever the free cells do.

    Args:
        grid: the map as known at first, with its low walls.
        places: by name.
        fence: north-east corners of the polygon that no route leaves.
        clearance_m: the least distance of a route from an obstacle, above it too.
        limits: the speeds by which the quickest route is chosen.
        fence_margin_m: the least distance from the fence.
        keep_out: the corners of areas that routes treat as obstacles.
        up_m: the altitude band; without it no route leads above both of its ends.
    """

    def __init__(
        self,
        grid: OccupancyGrid,
        places: Mapping[str, PlaceRegion],
        fence: Sequence[NorthEast],
        clearance_m: float,
        limits: SpeedLimits,
        fence_margin_m: float = 0.0,
        keep_out: Iterable[Sequence[NorthEast]] = (),
        up_m: tuple[float, float] = (-math.inf, -math.inf),
    ) -> None:
        self.version = 0
        self._lowest_m = up_m[0]
        self._grid, self._clearance_m, self._limits = grid, clearance_m, limits
        self._places = dict(places)
        self._fence, self._margin_m, self._keep_out = fence, fence_margin_m, tuple(keep_out)
        self._within: tuple[Sequence[NorthEast], ...] = ()
        self._goals = {name: place.position for name, place in places.items()}
        self._added_m = 0.0
        self._planes: dict[int, RouteMap] = {}
        self._tops, self._ceiling_m = _tops(grid, clearance_m, up_m[1]), up_m[1]
        self._unknown: set[str] = set()

    def hide(self, place: str) -> None:
        """Allows no routes to a place until it is found, because nobody knows where it is."""
        self._unknown.add(place)
        self.version += 1

    def find_place(self, place: str, goal: Ned) -> None:
        """Notes that a place was found or has moved; routes lead there from now on."""
        self._unknown.discard(place)
        self.aim(place, goal)
        self.version += 1

    def knows(self, place: str) -> bool:
        """Whether it is known where a place is."""
        return place not in self._unknown

    def _layer(self, up_m: float, added_m: float = 0.0) -> int:
        """The layer of a route at an altitude that keeps `added_m` more above walls."""
        return self._grid.layer(up_m - self._clearance_m - added_m + LEVEL_M)

    def _plane(self, layer: int) -> RouteMap:
        if layer not in self._planes:
            plane = RouteMap(
                self._grid.in_layer(layer),
                self._places,
                self._fence,
                self._clearance_m,
                self._margin_m,
                self._keep_out,
                self._within,
            )
            if self._added_m > 0:
                plane.add_clearance(self._added_m)
            for name, goal in self._goals.items():
                plane.aim(name, goal)
            self._planes[layer] = plane
        return self._planes[layer]

    def see(self, grid: OccupancyGrid) -> None:
        """Takes over a map with the same cells, of which others are occupied."""
        self._grid = grid
        before = [plane.version for plane in self._planes.values()]
        for layer, plane in self._planes.items():
            plane.see(grid.in_layer(layer))
        self.version += before != [plane.version for plane in self._planes.values()]

    def add_clearance(self, added_m: float) -> None:
        """Makes routes keep more distance from obstacles, where map or band have room for it."""
        self._added_m = added_m
        for plane in self._planes.values():
            plane.add_clearance(added_m)
        self.version += 1

    @property
    def kept_m(self) -> float:
        """The distance that routes keep from obstacles, where there is room."""
        return self._clearance_m + self._added_m

    def top_m(self, position: NorthEast, radius_m: float) -> float:
        """The top above home of whatever the map has below a vehicle; 0 for the ground."""
        return self._grid.ground_m(position, radius_m)[1]

    def plane(self, up_m: float) -> RouteMap | None:
        """The routes at an altitude, or the next lower one; None if none have been needed yet."""
        layer = self._layer(up_m)
        lower = max((n for n in self._planes if n < layer), default=layer)
        return self._planes.get(layer) or self._planes.get(lower)

    def keep_within(
        self, fences: Iterable[Sequence[NorthEast]], keep_out: Iterable[Sequence[NorthEast]]
    ) -> bool:
        """Makes routes stay in more fences and out of more areas; true if they have less room.
        Args:
            fences: polygons that no route leaves.
            keep_out: as in the constructor.
        """
        self._within = (*self._within, *fences)
        self._keep_out = (*self._keep_out, *keep_out)
        before, self._planes = self._planes, {}
        if before and all(self._plane(n).is_as_wide_as(plane) for n, plane in before.items()):
            self._planes = before
            return False
        self.version += 1
        return True

    def find(self, max_cells: int) -> bool:
        """Searches about `max_cells` cells of outdated distance maps; True once all are current."""
        ups_m = [-goal[2] for goal in self._goals.values()]
        layers = {self._layer(up_m, added_m) for added_m in self._margins for up_m in ups_m}
        layers |= {*self._tops}
        return all(self._plane(layer).find(max_cells) for layer in sorted(layers))

    def search(self, start: Ned, place: str, max_cells: int) -> bool:
        """Searches about `max_cells` cells for the routes to a place; True once they are known.

        Raises:
            KeyError: there is no such place.
        """
        layers = self._layers_to(start, place)
        return all(self._plane(layer).search(start[:2], place, max_cells) for layer in layers)

    def aim(self, place: str, goal: Ned) -> None:
        """Makes routes to a place end at another point; its region stays where it is."""
        self._goals[place] = goal
        for plane in self._planes.values():
            plane.aim(place, goal)

    def goal(self, place: str) -> Ned:
        """The point where routes to a place end now."""
        return self._goals[place]

    def is_clear(self, path: npt.NDArray[np.float64]) -> bool:
        """Whether a path (n, 3) has the least clearance, inside the fence and outside all zones.

        A path that begins in no free cell may lead out of there, as `RouteMap.is_clear` says.
        """
        lowest = np.minimum(-path[:-1, 2], -path[1:, 2])
        layers = [self._layer(float(up_m)) for up_m in lowest]
        changes = [i for i in range(1, len(layers)) if layers[i] != layers[i - 1]]
        runs = pairwise([0, *changes, len(layers)])
        return all(self._plane(layers[a]).is_clear(path[a : b + 1]) for a, b in runs)

    def is_free(self, position: Ned) -> bool:
        """Whether a position has the least clearance and lies inside the fence."""
        return self._plane(self._layer(-position[2])).is_free(position[:2])

    def is_connected(self, start: Ned, place: str) -> bool:
        """Whether free cells lead from near a start to a place, ignoring the regions in between."""
        layers = self._layers_to(start, place)
        return any(self._plane(layer).is_connected(start[:2], place) for layer in layers)

    def passage(self, start: Ned, place: str) -> Passage:
        """Lengths of the quickest route to a place.

        Raises:
            KeyError: there is no such place.
        """
        return self._quickest(start, place)[1]

    def _quickest(self, start: Ned, place: str) -> tuple[int, Passage]:
        """The quickest of the routes that keep most clearance, and its layer."""
        down_m = self._goals[place][2] - start[2]
        quickest = 0, Passage(math.inf, down_m)  # it is not known where the place is
        for added_m in self._margins:
            found = []
            for layer, level_up_m in self._ways(start, place, added_m):
                over_ground_m = self._plane(layer).distance_m(start[:2], place)
                climb_m = None if level_up_m is None else level_up_m + start[2]
                found.append((layer, Passage(over_ground_m, down_m, climb_m)))
            if found:
                quickest = min(found, key=lambda each: each[1].duration_s(self._limits))
            if math.isfinite(quickest[1].over_ground_m):
                break
        return quickest

    def distance_m(self, start: Ned, place: str) -> float:
        """Length of the quickest way to a place over the ground; inf if there is none."""
        return self.passage(start, place).over_ground_m

    def route(self, start: Ned, place: str) -> Route | None:
        """The quickest route to a place; None if there is none. See `RouteMap.route`."""
        if not self.knows(place):
            return None
        layer, passage = self._quickest(start, place)
        if passage.climb_m is None:
            return self._plane(layer).route(start, place)
        return self._stepped(start, place, passage.climb_m, self._plane(layer).route)

    def route_from_motion(self, start: Ned, stop: Ned, place: str) -> Route | None:
        """A route whose first leg leads straight ahead to where the vehicle can stop.

        None as in `RouteMap.route_from_motion`, and if the vehicle would have to climb there.

        Args:
            start: where the vehicle is.
            stop: where it can come to rest.
            place: where to fly.
        """
        if not self.knows(place):
            return None
        layer, passage = self._quickest(stop, place)
        if passage.climb_m is None:
            return self._plane(layer).route_from_motion(start, stop, place)
        if passage.climb_m > LEVEL_M or abs(stop[2] - start[2]) > LEVEL_M:
            return None

        def level(stop: Ned, place: str, down_m: float) -> Route | None:
            return self._plane(layer).route_from_motion(start, stop, place, down_m)

        return self._stepped(stop, place, 0.0, level)

    @property
    def _margins(self) -> tuple[float, ...]:
        """What routes keep above low walls beyond the least clearance, the most first."""
        is_more = self._added_m > 0 and self._grid.low is not None
        return (self._added_m, 0.0) if is_more else (0.0,)

    def _layers_to(self, start: Ned, place: str) -> Iterable[int]:
        """The layers of all routes to a place, each once."""
        levels = (each for added_m in self._margins for each in self._ways(start, place, added_m))
        return dict.fromkeys(layer for layer, _ in levels)

    def _ways(self, start: Ned, place: str, added_m: float) -> Iterator[tuple[int, float | None]]:
        """The routes to a place: layer, and altitude of the level part (None: it is sloped).
        Args:
            start: where the route begins.
            place: where it leads.
            added_m: what it keeps above low walls beyond the least clearance.
        """
        if not self.knows(place):
            return
        ups_m = (-start[2], -self._goals[place][2])
        low, high = self._layer(min(ups_m), added_m), self._layer(max(ups_m), added_m)
        must_climb = self._must_climb(start)
        if not must_climb and not self._is_above_an_edge(start, low, high):
            yield low, None
        if high != low or must_climb:
            yield high, max(ups_m)
        for layer, least_up_m in self._tops.items():
            up_m = min(least_up_m + self._added_m, self._ceiling_m)
            if layer > high and up_m >= least_up_m + added_m and up_m > max(ups_m):
                yield layer, up_m

    def _must_climb(self, start: Ned) -> bool:
        """Whether a start is below the band, or too low above a wall to leave it level."""
        up_m, top_m = -start[2], self._grid.ground_m(start[:2], 0.0)[1]
        is_low = top_m - LEVEL_M <= up_m < top_m + self._clearance_m - LEVEL_M
        return up_m < self._lowest_m - BELOW_M or (top_m > 0 and is_low)

    def _is_above_an_edge(self, start: Ned, low: int, high: int) -> bool:
        """Whether a start is clear of a wall only by its height, which a slope would lose."""
        here = start[:2]
        return (
            high != low and self._plane(high).is_free(here) and not self._plane(low).is_free(here)
        )

    def _stepped(self, start: Ned, place: str, climb_m: float, level: LevelRoute) -> Route | None:
        """A climb on the spot, a level route, a descent on the spot, as far as needed."""
        goal = self._goals[place]
        down_m = start[2] - climb_m
        route = level((*start[:2], down_m), place, down_m)
        if route is None:
            return None
        climbs, descends = start[2] > down_m + LEVEL_M, goal[2] > down_m + LEVEL_M
        waypoints = route.waypoints
        blends = list(route.blends or (None,) * (len(waypoints) - 2))
        if (climbs or descends) and route.length_m == 0.0:  # the place is straight above or below
            ends = [start] * climbs + [waypoints[0]] + [goal] * descends
            return Route(np.array(ends), (None,) * (len(ends) - 2))
        if climbs:
            waypoints, blends = np.vstack([start, waypoints]), [None, *blends]
        if descends:
            waypoints, blends = np.vstack([waypoints, goal]), [*blends, None]
        return Route(waypoints, tuple(blends))


def _tops(grid: OccupancyGrid, clearance_m: float, ceiling_m: float) -> dict[int, float]:
    """The layers above low walls, and the altitude from which each is flown in.

    At most MOST_TOPS of them: the one above all walls, and some between.
    """
    heights_m = grid.low.heights_m if grid.low is not None else ()
    tops = {i + 1: height_m + clearance_m for i, height_m in enumerate(heights_m)}
    within = [layer for layer, up_m in tops.items() if up_m <= ceiling_m]
    every = max(1, math.ceil(len(within) / MOST_TOPS))
    return {layer: tops[layer] for layer in sorted(within[::-1][::every])}
