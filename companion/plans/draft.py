"""Makes a mission of a flight plan, as data; mission_text.py writes it as YAML.

    waypoints    places, and a task: in this order, in any order, or again and again
    waits, commands    a skill at the place, and a fact that the task asks for on the way
    fence        the intersection of all inclusion areas; without one, a box around all places
    exclusions   keep-out zones
    rally points places that the task does not mention, where to land without a plan
    other points places that the task does not mention

Nothing that affects the flight is guessed: heights that the file does not have must be given, and
so must home.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

from companion.plans.areas import box, common, do_meet, is_inside
from companion.plans.draft_places import OTHER_HOME, Given, Places
from companion.plans.draft_task import HOME, skills_of, task_of
from companion.plans.route_plan import (
    ItemRefused,
    ItemsRefused,
    LatLon,
    RoutePlan,
    Waypoint,
    check_points,
    metres_between,
)

MAX_PLACES, MAX_STOPS = 60, 200
"""Limits of a route: planning either takes 10 s, and grows with the square."""
MAX_RALLY = 31
"""With home, the number of safe places that a mission may have, and a PX4 can store."""
MAX_AREAS = 100
FENCE_MARGIN_M = 20.0
BAND_M, AMSL_BAND_M = 3.0, 15.0
SPEED_MPS, MAX_SPEED_MPS = 5.0, 12.0
USUAL_UP_M, USUAL_REACH_M = 500.0, 5_000.0


@dataclass
class Draft:
    """A mission in the making.

    Attributes:
        data: the mission.
        items: by the keys of a place, of the fence or of a keep-out zone, its name in the file.
        notes: notes for the reader of the mission.
        route_m: length of the route, and then of the way to its end, in straight lines; None if the
            plan leaves the order open.
    """

    data: dict[str, Any]
    items: dict[tuple[str, ...], str]
    notes: list[str]
    route_m: tuple[float, float] | None = None


def draft(plan: RoutePlan, given: Given, name: str) -> Draft:
    """The mission that a plan describes.

    Args:
        plan: from a file.
        given: what the user has added.
        name: the name of the mission.

    Raises:
        ItemRefused, ItemsRefused: a mission cannot express something, or something is missing.
    """
    return _Drafting(plan, given).draft(name)


@dataclass
class _Drafting:
    """Drafts the places and the task of one plan."""

    plan: RoutePlan
    given: Given
    notes: list[str] = field(default_factory=list)
    items: dict[tuple[str, ...], str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self._placed = Places(self.plan, self.given, self.notes)
        self.places = self._placed.places

    def draft(self, name: str) -> Draft:
        plan, given = self.plan, self.given
        if plan.unaddressed and given.payload is None:
            raise ItemsRefused(plan.unaddressed)
        self.notes += plan.notes
        self._placed.tell_unused()
        placed = self._placed
        check_points(len(plan.waypoints) + len(plan.rally) + len(plan.spare))
        _all(partial(placed.with_height, waypoint) for waypoint in placed.of_known_height())
        placed.begin()
        _all(self._stops())
        end = placed.end
        placed.drop_repeats()
        if not placed.stops:
            self.notes.append("no waypoints: the mission only takes off and lands; add places")
        if plan.repeats_from is not None:
            self.notes.append("the loop is flown in the order in which a lap is shortest")
        _check_count(len(self.places) - 1, "places", MAX_PLACES)
        _check_count(len(placed.stops), "stops", MAX_STOPS)
        fence, zones = self._areas()
        safe = self._rally(fence, zones)
        self._spare(fence, zones)
        limits = self._limits(fence, zones)
        data: dict[str, Any] = {"version": 1, "name": name, "frame": "wgs84", "limits": limits}
        data["places"] = {name: placed.entry(place) for name, place in self.places.items()}
        data["sets"] = {"Place": [each for each in self.places if each not in placed.spare]}
        if given.payload is not None and plan.unaddressed:
            data["components"] = {"payload": given.payload}
        data["skills"] = skills_of(placed.stops)
        data["initially"] = [f"at({HOME})"]
        data["task"] = task_of(plan, placed.stops, end)
        data["otherwise"] = {"land_at": [HOME, *safe]} if safe else "return_home"
        places = {("places", name): place.item for name, place in self.places.items()}
        return Draft(data, self.items | places, self.notes, placed.route_m)

    def _stops(self) -> Iterator[Callable[[], None]]:
        """Steps that add the waypoints, up to one place more than allowed."""
        for waypoint in self.plan.waypoints:
            yield partial(self._placed.stop, waypoint)
            if len(self.places) - 1 > MAX_PLACES:
                return

    def _areas(self) -> tuple[tuple[LatLon, ...], dict[str, tuple[LatLon, ...]]]:
        """The fence, and the keep-out zones."""
        if len(self.plan.areas) > MAX_AREAS:
            what = f"has {len(self.plan.areas)} areas, more than {MAX_AREAS}"
            raise ItemRefused("", what, "leave out those that are far away")
        inclusions = [area for area in self.plan.areas if area.is_inclusion]
        if not inclusions:
            points = [place.position for place in self.places.values()]
            rally = (point.position for point in self.plan.rally[:MAX_RALLY])
            points += [p for p in rally if metres_between(points[0], p) < USUAL_REACH_M]
            self.notes.append(
                f"{self.plan.kind} has no fence; the box {FENCE_MARGIN_M:g} m around all places "
                "is one: make it as large as the vehicle may fly"
            )
            fence = box(points, FENCE_MARGIN_M)
        else:
            fence = common(inclusions).corners
            self.items["limits", "fence"] = inclusions[0].item
            if len(inclusions) > 1:
                self.notes.append(f"{len(inclusions)} inclusion areas: the fence is what all share")
        zones: dict[str, tuple[LatLon, ...]] = {}
        for area in self.plan.areas:
            if not area.is_inclusion and not do_meet(area.corners, fence):
                self.notes.append(f"{area.item}: lies outside the fence; left out")
            elif not area.is_inclusion:
                name = area.name
                while name in zones:
                    name += "_"
                zones[name] = area.corners
                self.items["limits", "keep_out", name] = area.item
        _all(partial(self._check_inside, place, fence, zones) for place in self.places.values())
        return fence, zones

    def _check_inside(
        self,
        place: Waypoint,
        fence: tuple[LatLon, ...],
        zones: dict[str, tuple[LatLon, ...]],
    ) -> None:
        if not is_inside(place.position, fence):
            raise ItemRefused(place.item, "is outside the fence of the plan", _to_move(place))
        for zone, corners in zones.items():
            if is_inside(place.position, corners):
                raise ItemRefused(
                    place.item, f"is inside the exclusion area {zone}", _to_move(place)
                )

    def _rally(self, fence: tuple[LatLon, ...], zones: dict[str, tuple[LatLon, ...]]) -> list[str]:
        """Adds rally points: places outside the task, where to land without a plan."""
        rally = len(self.plan.rally)
        if rally > MAX_RALLY:
            self.notes.append(f"{rally} rally points: the first {MAX_RALLY} are safe places")
        safe: list[str] = []
        for point in self.plan.rally[:MAX_RALLY]:
            name = self._place(point, fence, zones)
            if name in (None, HOME) or name in safe:
                continue
            assert name is not None
            safe.append(name)
            self.notes.append(f"{point.item}: the safe place {name}, to land at without a plan")
        return safe

    def _spare(self, fence: tuple[LatLon, ...], zones: dict[str, tuple[LatLon, ...]]) -> None:
        """Adds other places that the task does not mention."""
        spare = len(self.plan.spare)
        if spare > MAX_PLACES:
            self.notes.append(f"nothing flies to {spare} points; the first {MAX_PLACES} are places")
        for point in self.plan.spare[:MAX_PLACES]:
            known = len(self.places)
            name = self._place(point, fence, zones)
            if len(self.places) > known:
                self.notes.append(f"{point.item}: the place {name}, to which nothing flies yet")

    def _place(
        self,
        point: Waypoint,
        fence: tuple[LatLon, ...],
        zones: dict[str, tuple[LatLon, ...]],
    ) -> str | None:
        """The place at a point, which may be new; None where the vehicle must not be."""
        height = point.height
        if height is None and self.given.up_m is None:
            height = self.places[HOME].height
        placed = self._placed.with_height(replace(point, height=height))
        try:
            self._check_inside(placed, fence, zones)
        except ItemRefused as error:
            self.notes.append(f"{point.item}: {error.what}; left out")
            return None
        near = self._placed.near(placed)
        return self._placed.add(placed) if near is None else near

    def _limits(
        self, fence: tuple[LatLon, ...], zones: dict[str, tuple[LatLon, ...]]
    ) -> dict[str, Any]:
        heights = [self._placed.up_m(place) for place in self.places.values()]
        is_amsl = any(p.height is not None and p.height.is_amsl for p in self.places.values())
        margin_m = AMSL_BAND_M if is_amsl else BAND_M
        lowest, highest = max(0.5, min(heights) - margin_m), max(heights) + margin_m
        limits: dict[str, Any] = {
            "speed_mps": self._speed_mps(),
            "up_m": [round(lowest, 1), round(highest, 1)],
            "fence": [[round(degrees, 9) for degrees in corner] for corner in fence],
        }
        home = self.places[HOME].position
        reach_m = max(metres_between(home, corner) for corner in fence)
        if highest > USUAL_UP_M or reach_m > USUAL_REACH_M:
            limits["unusual"] = True
            self.notes.append(
                f"{highest:g} m high or {reach_m:.0f} m away is unusual: is it meant?"
            )
        if zones:
            limits["keep_out"] = {
                name: [[round(degrees, 9) for degrees in corner] for corner in corners]
                for name, corners in zones.items()
            }
        return limits

    def _speed_mps(self) -> float:
        asked = [speed for speed in self.plan.speeds_mps if speed > 0]
        if not asked:
            self.notes.append(f"no speed is given; {SPEED_MPS:g} m/s is written")
            return SPEED_MPS
        if len(set(asked)) > 1:
            self.notes.append(
                f"speeds {', '.join(f'{s:g}' for s in asked)} m/s: the least is meant"
            )
        if min(asked) > MAX_SPEED_MPS:
            self.notes.append(
                f"{min(asked):g} m/s is more than the vehicle's {MAX_SPEED_MPS:g} m/s"
            )
        return min(*asked, MAX_SPEED_MPS)


def _to_move(place: Waypoint) -> str:
    """Advice for a place and an area that contradict each other."""
    advice = "correct one of the two"
    return f"{advice}, or {OTHER_HOME}" if place.name == HOME else advice


def _all(steps: Iterable[Callable[[], object]]) -> None:
    """Runs some steps, and reports all refused items, each once."""
    refused: dict[tuple[str, str], ItemRefused] = {}
    for step in steps:
        try:
            step()
        except ItemRefused as error:
            refused.setdefault((error.item, error.what), error)
    if refused:
        raise ItemsRefused([*refused.values()])


def _check_count(count: int, what: str, most: int) -> None:
    if count > most:
        said = f"leads to more than {most} {what}, the most that a task is planned for"
        raise ItemRefused("", said, "split it, or draw fewer points (of a survey, its strips)")
