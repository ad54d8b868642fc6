"""Points, lines and polygons of a mapping tool as a flight plan: a class for each.

1. A point is a place.
2. A line is an order: its corners are places; a corner within a metre of a point is that point.
3. Points without a line are places in any order.
4. A single polygon without a `kind` is the fence.

    kind        of a polygon: fence or keep_out; of a point: place, home or rally;
                of a line: route, loop (repeated for ever) or flown (left out)

A point named Home without a kind is home, if no other point has this kind.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Protocol

from companion.plans.route_plan import (
    Height,
    ItemRefused,
    LatLon,
    PlanArea,
    RoutePlan,
    UnusedHeight,
    Waypoint,
    are_same,
    check_points,
    ring,
)

FENCE, KEEP_OUT = "fence", "keep_out"
HOME = "home"
DrawnHeight = Height | UnusedHeight | None
"""The height of a point in a file."""
NO_WORD = re.compile(r"[^A-Za-z0-9_]+")


@dataclass
class Drawn:
    """What the shapes so far have drawn."""

    homes: list[Waypoint] = field(default_factory=list)
    named_home: list[Waypoint] = field(default_factory=list)
    points: list[Waypoint] = field(default_factory=list)
    route: list[Waypoint] = field(default_factory=list)
    repeats_from: int | None = None
    areas: list[PlanArea] = field(default_factory=list)
    unnamed: list[str] = field(default_factory=list)
    rally: list[Waypoint] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)


class Shape(Protocol):
    """One shape of a file."""

    def draw(self, drawn: Drawn) -> None:
        """Adds the shape.

        Raises:
            ItemRefused: a mission cannot express it.
        """


@dataclass(frozen=True, slots=True)
class Point:
    """A place, home or a rally point."""

    item: str
    name: str
    kind: str
    position: LatLon
    height: DrawnHeight
    radius_m: float | None = None

    def draw(self, drawn: Drawn) -> None:
        """Adds it by its kind."""
        point = _waypoint(self.item, self.name, self.position, self.height, self.radius_m)
        if not self.kind and self.name.lower() == HOME:
            drawn.named_home.append(point)
        elif self.kind in ("", "place"):
            drawn.points.append(point)
        elif self.kind == HOME:
            drawn.homes.append(point)
        elif self.kind == "rally":
            drawn.rally.append(point)
        else:
            raise _unknown(self.item, self.kind, "place, home or rally")


@dataclass(frozen=True, slots=True)
class Line:
    """An order of places."""

    item: str
    name: str
    kind: str
    corners: tuple[tuple[LatLon, DrawnHeight], ...]

    def draw(self, drawn: Drawn) -> None:
        """Adds each corner as a waypoint."""
        if self.kind == "flown":
            drawn.notes.append(f"{self.item}: a way that was flown; left out")
            return
        if self.kind not in ("", "route", "loop"):
            raise _unknown(self.item, self.kind, "route, loop or flown")
        if drawn.repeats_from is not None:
            raise ItemRefused(self.item, "comes after a loop, which never ends", "remove one")
        if drawn.route and self.kind != "loop":
            raise ItemRefused(self.item, "is a second route", "join the two, or remove one")
        if self.kind == "loop":
            drawn.repeats_from = len(drawn.route)
        first = len(drawn.route)
        for index, (position, height) in enumerate(self.corners, 1):
            item = f"corner {index} of {self.item}"
            drawn.route.append(_waypoint(item, f"W{first + index}", position, height))


@dataclass(frozen=True, slots=True)
class Polygon:
    """The fence or a keep-out zone, with holes into which the vehicle must not fly."""

    item: str
    name: str
    kind: str
    corners: tuple[LatLon, ...]
    holes: tuple[tuple[LatLon, ...], ...] = ()

    def draw(self, drawn: Drawn) -> None:
        """Adds it by its kind."""
        if self.kind not in ("", FENCE, KEEP_OUT):
            raise _unknown(self.item, self.kind, f"{FENCE} or {KEEP_OUT}")
        if self.kind == KEEP_OUT and self.holes:
            raise ItemRefused(self.item, "is a keep-out zone with holes", "fill them")
        if not self.kind:
            drawn.unnamed.append(self.item)
        name = self.name or f"zone_{len(drawn.areas) + 1}"
        corners = ring(self.item, self.corners)
        drawn.areas.append(PlanArea(self.item, name, corners, self.kind != KEEP_OUT))
        for index, hole in enumerate(self.holes, 1):
            item = f"hole {index} of {self.item}"
            drawn.areas.append(PlanArea(item, f"{name}_hole_{index}", ring(item, hole), False))


def _waypoint(
    item: str, name: str, position: LatLon, height: DrawnHeight, radius_m: float | None = None
) -> Waypoint:
    """A waypoint with its height, if that is used."""
    if isinstance(height, UnusedHeight):
        return Waypoint(item, name, position, None, (), radius_m, unused=height)
    return Waypoint(item, name, position, height, (), radius_m)


def _unknown(item: str, kind: str, known: str) -> ItemRefused:
    return ItemRefused(item, f"is of the kind {kind[:40]!r}", f"its kind may be {known}")


def word(name: str) -> str:
    """A name as missions spell names; empty if no valid character is left.

    >>> word("North gate, 2"), word("2nd"), word("...")
    ('North_gate_2', '_2nd', '')
    """
    spelt = NO_WORD.sub("_", name.strip()).strip("_")[:30]
    return f"_{spelt}" if spelt[:1].isdigit() else spelt


def plan_of(kind: str, shapes: Sequence[Shape], notes: Sequence[str] = ()) -> RoutePlan:
    """The plan that some shapes draw.

    Args:
        kind: the kind of their file, in words.
        shapes: in the order of the file.
        notes: notes for its reader.

    Raises:
        ItemRefused: a mission cannot express them.
    """
    drawn = Drawn(notes=list(notes))
    for shape in shapes:
        shape.draw(drawn)
    if drawn.unnamed and sum(area.is_inclusion for area in drawn.areas) > 1:
        what = "is one of several polygons, and does not say what it is"
        raise ItemRefused(drawn.unnamed[-1], what, f"give it the kind {FENCE} or {KEEP_OUT}")
    home, home_note = _home(drawn)
    check_points(len(drawn.route) + len(drawn.points) + len(drawn.rally))
    is_ordered = bool(drawn.route)
    points = [*drawn.points, home] if home else drawn.points
    waypoints = [_as_point(each, points) for each in drawn.route]
    on_the_line = {waypoint.item for waypoint in waypoints}
    waypoints += [point for point in drawn.points if point.item not in on_the_line]
    if is_ordered and len(waypoints) > len(drawn.route):
        extra = ", ".join(point.item for point in waypoints[len(drawn.route) :][:10])
        drawn.notes.append(f"not on the line, and so never flown to: {extra}")
    drawn_points = [*waypoints, *drawn.rally, *([home] if home else [])]
    route = waypoints[: len(drawn.route)] if is_ordered else waypoints
    return RoutePlan(
        kind=kind,
        home=home.position if home else None,
        home_note=home_note,
        takeoff=home.height if home else None,
        takeoff_item=home.item if home else "",
        waypoints=tuple(route),
        is_ordered=is_ordered,
        repeats_from=drawn.repeats_from,
        areas=tuple(drawn.areas),
        rally=tuple(drawn.rally),
        spare=tuple(waypoints[len(route) :]),
        unused=tuple(each.unused for each in drawn_points if each.unused and not each.height),
        notes=tuple(drawn.notes),
    )


def _home(drawn: Drawn) -> tuple[Waypoint | None, str]:
    """The point where the mission begins, and a note on it.

    Raises:
        ItemRefused: there are several.
    """
    homes, named = drawn.homes, drawn.named_home
    if homes:
        drawn.points += named
    if len(homes or named) > 1:
        which = f"is a second point of the kind {HOME}" if homes else "is a second point named Home"
        advice = f"leave one, or give one the kind {HOME} and the other ones the kind place"
        raise ItemRefused((homes or named)[1].item, which, advice)
    if homes:
        return homes[0], ""
    return (named[0], f"home is {named[0].item}, by its name") if named else (None, "")


def _as_point(corner: Waypoint, points: Sequence[Waypoint]) -> Waypoint:
    """The waypoint for a corner of the line: at the point near it, if there is one."""
    for point in points:
        if are_same(point.position, corner.position):
            height, unused = point.height or corner.height, point.unused or corner.unused
            return replace(point, height=height, unused=unused)
    return corner
