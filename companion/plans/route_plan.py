"""A flight plan from another program, as far as a mission can express it.

Every reader converts its file into a `RoutePlan`, from which draft.py makes a mission. Positions
are in degrees (WGS 84), as in the files. Each part knows its name in the file ("item 7", "feature
2"), by which it is refused if it cannot be expressed.
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
"""Most refusals that are listed in one message."""

SAME_M = 1.0
"""Points nearer to each other than this are one place."""

MAX_POINTS = 2000
"""Most points of a file; each is compared with every place. Plans of 800 waypoints exist."""

LatLon = tuple[float, float]
"""Degrees north, degrees east."""


@dataclass(frozen=True, slots=True)
class Height:
    """A height.

    Attributes:
        metres: above home, or above mean sea level.
        is_amsl: which of the two.
    """

    metres: float
    is_amsl: bool = False


@dataclass(frozen=True, slots=True)
class UnusedHeight:
    """A height in a file, above something whose height a mission does not know.

    Attributes:
        metres: as the file has it.
        above: its reference, with the words before it: " above the ground".
    """

    metres: float
    above: str


@dataclass(frozen=True, slots=True)
class Hold:
    """Wait for a time."""

    seconds: float

    @property
    def step(self) -> str:
        """The step of a skill."""
        return f"wait({self.seconds:g})"


@dataclass(frozen=True, slots=True)
class Send:
    """Send a command to the payload.

    Attributes:
        item: its name in messages.
        height: the height of the command's position; None if it has none.
    """

    command: str
    params: tuple[float, ...]
    item: str = ""
    height: Height | None = None

    @property
    def step(self) -> str:
        """The step of a skill."""
        numbers = "".join(f", {value:.9g}" for value in self.params)
        return f"command(payload, {self.command}{numbers})"


Act = Hold | Send
"""What is done at a waypoint."""


@dataclass(frozen=True, slots=True)
class Waypoint:
    """A waypoint.

    Attributes:
        item: its name in messages, such as "item 7".
        name: a name for its place, one word.
        radius_m: as in the file; None if it has none.
        unused: the height in the file that is not used.
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
    """A polygon to stay in, or out of; its last corner differs from the first one."""

    item: str
    name: str
    corners: tuple[LatLon, ...]
    is_inclusion: bool


@dataclass(frozen=True, slots=True)
class RoutePlan:
    """The content of a file.

    Attributes:
        kind: the kind of the file, in words.
        home: where the flight begins; None if the file does not say it.
        home_amsl_m: its height above sea level.
        home_note: a note for the reader of a mission that begins there.
        takeoff: height of the take-off.
        takeoff_item: the item that says it.
        start_acts: acts before the first waypoint.
        waypoints: in the order of the flight.
        is_ordered: whether this order matters.
        repeats_from: index of the waypoint where an endless loop begins; None without a loop.
        lands_at_last: whether the flight ends at the last waypoint; otherwise at home.
        speeds_mps: all speeds in the file.
        areas: inclusions and exclusions.
        rally: rally points; they have no acts.
        spare: other points that are not flown to; they have no acts.
        unused: heights in the file that are replaced by others.
        notes: notes for the reader of the mission, one line each.
        unaddressed: errors for the payload commands if their receiver is unknown.
        correction: advice for an item that cannot be expressed.
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
    notes: tuple[str, ...] = ()
    unaddressed: tuple[ItemRefused, ...] = ()
    correction: str = "correct it in the program that has drawn it"


class ItemRefused(Exception):
    """A part of a file that a mission cannot express.

    Args:
        item: its name, such as "item 7"; empty for the whole file.
        what: what is wrong with it.
        hint: what to do.
    """

    def __init__(self, item: str, what: str, hint: str = "") -> None:
        super().__init__(item, what, hint)
        self.item, self.what, self.hint = item, what, hint


class ItemsRefused(Exception):
    """Several parts of a file that a mission cannot express."""

    def __init__(self, refused: Sequence[ItemRefused]) -> None:
        super().__init__(refused)
        self.refused = tuple(refused)


def refusal_of(path: str, refused: Sequence[ItemRefused]) -> MissionError:
    """The error for a file that is not imported.

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
    """A valid position on the earth, with a longitude from -180 to 180.

    Maps drawn across the 180th meridian continue to count beyond it.

    >>> check_degrees("point 1", -16.8, 180.25)
    (-16.8, -179.75)

    Raises:
        ItemRefused: the position is invalid.
    """
    if not (abs(latitude) <= 90 and abs(longitude) <= 360):
        what = f"latitude {latitude:g}, longitude {longitude:g} is nowhere on the earth"
        raise ItemRefused(item, what, "are the two exchanged?")
    return (latitude, math.remainder(longitude, 360.0))


def ring(item: str, corners: Iterable[LatLon]) -> tuple[LatLon, ...]:
    """The corners of a polygon, without a last one that repeats the first.

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
    """Refuses a file with more points than `MAX_POINTS`.

    Raises:
        ItemRefused: it has too many points.
    """
    if count > MAX_POINTS:
        raise ItemRefused("", f"has {count} points, more than {MAX_POINTS}", "split it")


def are_same(a: LatLon, b: LatLon) -> bool:
    """Whether two points are one place; a thousandth of a degree is 111 m from south to north."""
    return abs(a[0] - b[0]) < 0.001 and metres_between(a, b) < SAME_M


def metres_between(a: LatLon, b: LatLon) -> float:
    """The horizontal distance."""
    return math.hypot(*GlobalOrigin(*a, 0.0).to_local(*b, 0.0)[:2])
