"""A flight plan from elsewhere, as far as a mission can mean it.

Every reader makes a `RoutePlan` of its file, and mission_data.py makes a mission of a `RoutePlan`.
Positions are degrees (WGS 84), as the files have them. Each thing knows the name that its file
gives it ("item 7", "feature 2"), so that whatever cannot be meant is refused by it.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import islice

from companion.errors import MissionError
from companion.geometry import GlobalOrigin
from companion.motion.polygons import MAX_CORNERS

SHOWN = 20
"""Refusals that are listed in one message."""

SAME_M = 1.0
"""Points that are nearer to each other are one place."""

MAX_POINTS = 2000
"""Of a file; each is compared with every place. Plans of 800 waypoints exist."""

LatLon = tuple[float, float]
"""Degrees north, degrees east."""


@dataclass(frozen=True, slots=True)
class Height:
    """How high something is.

    Attributes:
        metres: above home, or above mean sea level.
        is_amsl: which of the two.
    """

    metres: float
    is_amsl: bool = False


@dataclass(frozen=True, slots=True)
class UnusedHeight:
    """A height that a file has, above something of which a mission does not know where it is.

    Attributes:
        metres: as the file has it.
        above: what it is above, with what leads over to it: " above the ground".
    """

    metres: float
    above: str


@dataclass(frozen=True, slots=True)
class Hold:
    """Stay for a time."""

    seconds: float

    @property
    def step(self) -> str:
        """As a step of a skill."""
        return f"wait({self.seconds:g})"


@dataclass(frozen=True, slots=True)
class Send:
    """Send a command to the payload.

    Attributes:
        item: its name in messages.
        height: of the position that the command has; None if it has none.
    """

    command: str
    params: tuple[float, ...]
    item: str = ""
    height: Height | None = None

    @property
    def step(self) -> str:
        """As a step of a skill."""
        numbers = "".join(f", {value:.9g}" for value in self.params)
        return f"command(payload, {self.command}{numbers})"


Act = Hold | Send
"""What is done at a waypoint."""


@dataclass(frozen=True, slots=True)
class Waypoint:
    """A point that is flown to.

    Attributes:
        item: its name in messages, e.g. "item 7".
        name: a name for its place, a word.
        radius_m: that the file asks for; None if it does not.
        unused: what the file has in place of a height that counts.
    """

    item: str
    name: str
    position: LatLon
    height: Height | None
    acts: tuple[Act, ...] = ()
    radius_m: float | None = None
    unused: UnusedHeight | None = None


@dataclass(frozen=True, slots=True)
class PlanArea:
    """A polygon that is not left, or not entered; its last corner is not the first one again."""

    item: str
    name: str
    corners: tuple[LatLon, ...]
    is_inclusion: bool


@dataclass(frozen=True, slots=True)
class RoutePlan:
    """What a file says.

    Attributes:
        kind: of the file, in words.
        home: where the flight begins; None if the file does not say it.
        home_amsl_m: how high that lies above the sea.
        home_note: what the reader of a mission that begins there has to know.
        takeoff: the height of the first hover.
        takeoff_item: that says it.
        start_acts: what is done before the first waypoint.
        waypoints: in the order of the flight.
        is_ordered: whether this order is meant.
        repeats_from: index of the waypoint with which an endless loop begins; None without one.
        lands_at_last: whether the flight ends at the last waypoint; else it comes home.
        speeds_mps: that the file asks for.
        areas: inclusions and exclusions.
        rally: rally points; they have no acts.
        spare: other points that nothing flies to; so have they.
        unused: heights of the file in whose place others stand.
        told: what a reader of the mission has to know, a line each.
        unaddressed: the commands for payloads, as they are refused where nobody says who gets them.
        correction: what to do about an item that cannot be meant.
    """

    kind: str
    home: LatLon | None = None
    home_amsl_m: float | None = None
    home_note: str = ""
    takeoff: Height | None = None
    takeoff_item: str = ""
    start_acts: tuple[Act, ...] = ()
    waypoints: tuple[Waypoint, ...] = ()
    is_ordered: bool = True
    repeats_from: int | None = None
    lands_at_last: bool = False
    speeds_mps: tuple[float, ...] = ()
    areas: tuple[PlanArea, ...] = ()
    rally: tuple[Waypoint, ...] = ()
    spare: tuple[Waypoint, ...] = ()
    unused: tuple[UnusedHeight, ...] = ()
    told: tuple[str, ...] = ()
    unaddressed: tuple[ItemRefused, ...] = ()
    correction: str = "correct it in the program that has drawn it"


class ItemRefused(Exception):
    """Something of a file that a mission cannot mean.

    Args:
        item: its name, e.g. "item 7"; empty for the whole file.
        what: is wrong with it.
        hint: what to do.
    """

    def __init__(self, item: str, what: str, hint: str = "") -> None:
        super().__init__(item, what, hint)
        self.item, self.what, self.hint = item, what, hint


class ItemsRefused(Exception):
    """Several such things."""

    def __init__(self, refused: Sequence[ItemRefused]) -> None:
        super().__init__(refused)
        self.refused = tuple(refused)


def refusal_of(path: str, refused: Sequence[ItemRefused]) -> MissionError:
    """What is told of a file that is not imported.

    >>> print(refusal_of("field.plan", [ItemRefused("item 7", "is for planes", "leave it out")]))
    field.plan: item 7: is for planes
        leave it out
    """
    if len(refused) == 1:
        (only,) = refused
        what = f"{only.item}: {only.what}" if only.item else only.what
        return MissionError(f"{path}: {what}", hint=only.hint)
    lines = [f"{each.item}: {each.what}" for each in refused[:SHOWN]]
    lines += [f"and {len(refused) - SHOWN} more"] if len(refused) > SHOWN else []
    lines += dict.fromkeys(each.hint for each in refused if each.hint)
    return MissionError(f"{path}: {len(refused)} items cannot be imported", hint="\n".join(lines))


def check_degrees(item: str, latitude: float, longitude: float) -> LatLon:
    """A position, if there is such a one on the earth, with a longitude from -180 to 180.

    Maps that are drawn across the 180th meridian count on beyond it.

    >>> check_degrees("point 1", -16.8, 180.25)
    (-16.8, -179.75)

    Raises:
        ItemRefused: there is none.
    """
    if not (abs(latitude) <= 90 and abs(longitude) <= 360):
        what = f"latitude {latitude:g}, longitude {longitude:g} is nowhere on the earth"
        raise ItemRefused(item, what, "are the two exchanged?")
    return (latitude, math.remainder(longitude, 360.0))


def ring(item: str, corners: Iterable[LatLon]) -> tuple[LatLon, ...]:
    """The corners of a polygon, without the last one if that is the first one again.

    Raises:
        ItemRefused: fewer than three are left, or there are too many.
    """
    listed = tuple(islice(corners, MAX_CORNERS + 2))
    if len(listed) > 1 and listed[0] == listed[-1]:
        listed = listed[:-1]
    if len(listed) < 3:
        raise ItemRefused(item, f"a polygon of {len(listed)} corners has no area", "draw it anew")
    if len(listed) > MAX_CORNERS:
        what = f"is a polygon of more than {MAX_CORNERS} corners"
        raise ItemRefused(item, what, "draw it with fewer: each setpoint is held against them")
    return listed


def check_points(count: int) -> None:
    """Whether a file has no more points than are looked at.

    Raises:
        ItemRefused: it has.
    """
    if count > MAX_POINTS:
        raise ItemRefused("", f"has {count} points, more than {MAX_POINTS}", "split it")


def are_same(a: LatLon, b: LatLon) -> bool:
    """Whether two points are one place; a thousandth of a degree is 111 m from south to north."""
    return abs(a[0] - b[0]) < 0.001 and metres_between(a, b) < SAME_M


def metres_between(a: LatLon, b: LatLon) -> float:
    """Distance on the ground."""
    return math.hypot(*GlobalOrigin(*a, 0.0).to_local(*b, 0.0)[:2])
