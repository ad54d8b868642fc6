"""The places of a drafted mission, and the stops of its route at them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import Any

from companion.geometry import FAR_M
from companion.plans.draft_task import HOME, RouteStop
from companion.plans.route_plan import (
    SAME_M,
    Act,
    Height,
    ItemRefused,
    LatLon,
    RoutePlan,
    Send,
    UnusedHeight,
    Waypoint,
    are_same,
    metres_between,
)

SAY_AMSL = "say it: --home LAT,LON,AMSL"
OTHER_HOME = "say where the mission begins: --home LAT,LON"
RADIUS_M = 2.0
SHOWN = 8
"""Most points that are listed in one line."""


@dataclass(frozen=True, slots=True)
class Given:
    """What the user says in addition to the file.

    Attributes:
        home: where the mission begins.
        home_amsl_m: its height above sea level.
        up_m: height above home of points that have none in the file.
        payload: MAVLink component id for the payload commands.
    """

    home: LatLon | None = None
    home_amsl_m: float | None = None
    up_m: float | None = None
    payload: int | None = None


@dataclass
class Places:
    """The places of one plan.

    Attributes:
        notes: notes for the reader of the mission.
        places: by their names, home first.
        stops: the stops of the route.
    """

    plan: RoutePlan
    given: Given
    notes: list[str]
    places: dict[str, Waypoint] = field(default_factory=dict)
    stops: list[RouteStop] = field(default_factory=list)
    _again: list[str] = field(default_factory=list)

    def begin(self) -> None:
        """Adds home, and its acts before the first waypoint.

        Raises:
            ItemRefused: the position or the height of home is unknown.
        """
        plan, first = self.plan, next(iter(self.plan.waypoints), None)
        home = self.given.home or plan.home
        if self.given.home is None and plan.home_note:
            self.notes.append(plan.home_note)
        if home and plan.home and (away_m := metres_between(home, plan.home)) >= SAME_M:
            self.notes.append(f"home in the file is {away_m:.0f} m from --home, which counts")
        if home is None and first is not None:
            home = first.position
            self.notes.append(f"{plan.kind} says nothing of home; it is put at {first.item}")
        if home is None:
            what = "says neither where the mission begins nor where it leads"
            raise ItemRefused("", what, OTHER_HOME)
        height = plan.takeoff or (first.height if first else None)
        if height is None and not plan.waypoints and self.given.up_m is None:
            what = "says nothing of how high to fly"
            raise ItemRefused("", what, "say how high above home: --up-m 20")
        says_height = plan.takeoff_item if plan.takeoff else first.item if first else "home"
        unused = first.unused if first else None
        placed = self.with_height(Waypoint(says_height, HOME, home, height, unused=unused))
        self.places[HOME] = replace(placed, item="home")
        if plan.start_acts:
            self.stops.append(RouteStop(HOME, self._sent(plan.start_acts), "start"))

    def stop(self, waypoint: Waypoint) -> None:
        """Adds a waypoint of the route: at a new place, or at one within a metre.

        Raises:
            ItemRefused: it is too far away, too low, or above or below another place.
        """
        waypoint = self.with_height(waypoint)
        away_m = metres_between(self.places[HOME].position, waypoint.position)
        if away_m > FAR_M:
            what = f"is {away_m / 1000:.0f} km from home"
            hint = "no mission reaches beyond 10 km; correct it, or say where home is: --home"
            raise ItemRefused(waypoint.item, what, hint)
        name = self.near(waypoint)
        if name is None:
            name = self.add(waypoint)
        elif waypoint is not self._landing and self._heights_differ(self.places[name], waypoint):
            self._raise(name, waypoint)
        elif name != HOME:
            self._again.append(f"{waypoint.item} at {name}")
        self.stops.append(RouteStop(name, self._sent(waypoint.acts), waypoint.name))

    def _sent(self, acts: tuple[Act, ...]) -> tuple[Act, ...]:
        """The same acts, with positions as in a command to a payload.

        COMMAND_LONG has no frame, so its altitude is above sea level.
        """
        return tuple(
            replace(act, params=(*act.params[:6], self._amsl_m(act.height, act)))
            if isinstance(act, Send) and act.height is not None
            else act
            for act in acts
        )

    def _amsl_m(self, height: Height, act: Send) -> float:
        if height.is_amsl:
            return height.metres
        if self._home_amsl_m is None:
            what = f"{act.command} goes to a payload with an altitude above the sea, and the one of"
            what += " the plan is above home; nothing says how high home lies"
            raise ItemRefused(act.item, what, SAY_AMSL)
        amsl_m = height.metres + self._home_amsl_m
        self.notes.append(
            f"{act.item}: {height.metres:g} m above home is sent as {amsl_m:g} m above the sea"
        )
        return amsl_m

    def add(self, waypoint: Waypoint) -> str:
        """Adds a place, and returns its name."""
        name = waypoint.name
        while name in self.places:
            name += "_"
        self.places[name] = waypoint
        return name

    def near(self, waypoint: Waypoint) -> str | None:
        """The place within a metre of a point, horizontally."""
        for name, place in self.places.items():
            if are_same(place.position, waypoint.position):
                return name
        return None

    @property
    def end(self) -> str:
        """The place where the flight ends; call it before `drop_repeats`."""
        return self.stops[-1].place if self.stops and self.plan.lands_at_last else HOME

    @property
    def route_m(self) -> tuple[float, float] | None:
        """Length of the way along the stops and then to the end, in straight lines.

        None without stops, or if the planner chooses their order. Call it after `drop_repeats`.
        """
        is_fixed = self.plan.is_ordered or len(self.stops) == 1
        if not self.stops or not is_fixed or self.plan.repeats_from is not None:
            return None
        names = [HOME, *(stop.place for stop in self.stops)]
        points = [self.places[name].position for name in (*names, self.end)]
        *legs_m, back_m = (metres_between(a, b) for a, b in pairwise(points))
        return sum(legs_m), back_m

    @property
    def _landing(self) -> Waypoint | None:
        """The waypoint where the flight ends on the ground, from any height."""
        return self.plan.waypoints[-1] if self.plan.lands_at_last and self.plan.waypoints else None

    def _raise(self, name: str, waypoint: Waypoint) -> None:
        """Makes the vehicle take off to a waypoint's height above home; moves no other place."""
        place = self.places[name]
        is_takeoff = name == HOME and place.height == self.plan.takeoff
        if not is_takeoff or self.up_m(waypoint) < self.up_m(place):
            what = f"is above or below {place.item}, at another height"
            hint = "move one of them by some metres, or leave it out"
            raise ItemRefused(waypoint.item, what, hint)
        self.places[HOME] = replace(place, height=waypoint.height)
        low_m, high_m = self.up_m(place), self.up_m(waypoint)
        self.notes.append(
            f"{waypoint.item}: above home; so the takeoff is to {high_m:g} m and not to {low_m:g} m"
        )

    def drop_repeats(self) -> None:
        """Drops stops where the vehicle is already, and a way home that it takes anyway."""
        if self._again:
            more = f" and {len(self._again) - SHOWN} more" if len(self._again) > SHOWN else ""
            shown = ", ".join(self._again[:SHOWN])
            self.notes.append(f"within a metre of a point before, so the same place: {shown}{more}")
        repeats_from = self.plan.repeats_from
        if repeats_from is not None:
            if repeats_from and self.stops[0][:2] == (HOME, ()):
                del self.stops[0]
            return
        before = [HOME, *(stop.place for stop in self.stops)]
        told_apart = zip(before, self.stops, strict=False)
        self.stops = [stop for last, stop in told_apart if stop.acts or stop.place != last]
        if self.stops and self.stops[-1][:2] == (HOME, ()):
            del self.stops[-1]

    def of_known_height(self) -> Iterator[Waypoint]:
        """The waypoints whose height above home is known.

        A landing has the height of the waypoint before, and is not reported for that.
        """
        for waypoint in self.plan.waypoints:
            height = waypoint.height
            if height is None or waypoint is self._landing:
                continue
            if self._home_amsl_m is not None or not height.is_amsl:
                yield waypoint

    def with_height(self, waypoint: Waypoint) -> Waypoint:
        """A waypoint with its own height, or the height given for points without one.

        Raises:
            ItemRefused: it has no height, or is not above home.
        """
        height = waypoint.height
        if height is None:
            if self.given.up_m is None:
                what = "has no altitude above home or above the sea"
                if waypoint.unused is not None:
                    what = f"its altitude is {_in_words([waypoint.unused])}, and a mission knows"
                    what += " altitudes above home or above the sea alone"
                raise ItemRefused(waypoint.item, what, "say how high above home: --up-m 20")
            return replace(waypoint, height=Height(self.given.up_m))
        if height.is_amsl:
            home_amsl_m = self._home_amsl_m
            if home_amsl_m is None:
                what = "its altitude is above the sea, and nothing says how high home lies"
                raise ItemRefused(waypoint.item, what, SAY_AMSL)
            if height.metres - home_amsl_m < 1.0:
                what = f"is at {height.metres:g} m above the sea, and home at {home_amsl_m:g} m"
                hint = f"{self.plan.correction},\nor say how high home lies: --home LAT,LON,AMSL"
                raise ItemRefused(waypoint.item, what, hint)
        elif height.metres < 1.0:
            what = f"is at {height.metres:g} m above home"
            hint = f"a vehicle flies at 1 m or higher: {self.plan.correction}"
            raise ItemRefused(waypoint.item, what, hint)
        return waypoint

    def _heights_differ(self, place: Waypoint, other: Waypoint) -> bool:
        assert place.height is not None and other.height is not None
        if place.height.is_amsl == other.height.is_amsl:
            return abs(place.height.metres - other.height.metres) >= SAME_M
        return self._home_amsl_m is None or abs(self.up_m(place) - self.up_m(other)) >= SAME_M

    def tell_unused(self) -> None:
        """Adds a note on heights of the file that are not used, and what replaces them."""
        up_m = self.given.up_m
        instead = "the height of Home" if up_m is None else f"{up_m:g} m above home, by --up-m"
        for above in dict.fromkeys(each.above for each in self.plan.unused):
            heights = [each for each in self.plan.unused if each.above == above]
            those = "1 altitude" if len(heights) == 1 else f"{len(heights)} altitudes"
            words = _in_words(heights)
            self.notes.append(f"not used: {those} of the file, {words}; in place of that {instead}")

    @property
    def _home_amsl_m(self) -> float | None:
        if self.given.home is not None:
            return self.given.home_amsl_m
        return self.plan.home_amsl_m

    def up_m(self, place: Waypoint) -> float:
        """Height of a place above home."""
        assert place.height is not None
        if not place.height.is_amsl:
            return place.height.metres
        assert self._home_amsl_m is not None
        return place.height.metres - self._home_amsl_m

    @property
    def spare(self) -> set[str]:
        """Places to which nothing flies."""
        used = {HOME, *(stop.place for stop in self.stops)}
        return set(self.places) - used

    def entry(self, place: Waypoint) -> dict[str, Any]:
        """A place as a mission has it."""
        assert place.height is not None
        others = (other for other in self.places.values() if other is not place)
        near_m = [metres_between(place.position, other.position) for other in others]
        radius_m = min([place.radius_m or RADIUS_M, *(0.4 * apart_m for apart_m in near_m)])
        latitude, longitude = place.position
        key = "amsl_m" if place.height.is_amsl else "up_m"
        return {
            "lat_deg": round(latitude, 9),
            "lon_deg": round(longitude, 9),
            key: round(place.height.metres, 3),
            "radius_m": round(min(radius_m, 50.0), 2),
        }


def _in_words(heights: Sequence[UnusedHeight]) -> str:
    """Heights above the same reference, in words.

    >>> _in_words([UnusedHeight(metres, " above the ground") for metres in (12.0, 25.0, 18.0)])
    '12 to 25 m above the ground'
    """
    low_m, high_m = (choose(each.metres for each in heights) for choose in (min, max))
    return f"{low_m:g}{f' to {high_m:g}' if high_m > low_m else ''} m{heights[0].above}"
