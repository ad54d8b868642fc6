"""The items of a flight plan, and the route that they make together.

A `CommandItem` has the fields of MAVLink's MISSION_ITEM, which .plan, .mission and WPL files share.
meanings.py says what each of them adds to a `PlannedRoute`.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

from companion.mavlink.framing import dialect
from companion.mavlink.payload_commands import PAYLOAD_COMMANDS
from companion.plans.route_plan import (
    Act,
    Height,
    ItemRefused,
    LatLon,
    PlanArea,
    RoutePlan,
    Waypoint,
    are_same,
    check_degrees,
)

AMSL_FRAMES = frozenset({dialect.MAV_FRAME_GLOBAL, dialect.MAV_FRAME_GLOBAL_INT})
RELATIVE_FRAMES = frozenset(
    {dialect.MAV_FRAME_GLOBAL_RELATIVE_ALT, dialect.MAV_FRAME_GLOBAL_RELATIVE_ALT_INT}
)
TERRAIN_FRAMES = frozenset(
    {dialect.MAV_FRAME_GLOBAL_TERRAIN_ALT, dialect.MAV_FRAME_GLOBAL_TERRAIN_ALT_INT}
)
LEAVE_OUT = "correct the plan, or leave items out by their numbers: --leave-out 3,7"
PAYLOADS = "payloads"
"""Stands for the numbers of all payload commands where items are left out."""


def not_an_item(number: str) -> ItemRefused:
    """The error for an item to leave out that does not exist."""
    what = f"has no item {number[:20]!r} that could be left out"
    advice = "items have the numbers that messages give them, as in --leave-out 3,3.2"
    return ItemRefused("", what, advice)


@dataclass(frozen=True, slots=True)
class CommandItem:
    """An item of a plan.

    Attributes:
        number: its place in the plan, such as "7", or "7.2" within a survey.
        params: seven; None where the plan has no value.
        jump_id: the id by which a jump refers to it.
    """

    number: str
    command: int
    frame: int
    params: tuple[float | None, ...]
    jump_id: int

    @property
    def item(self) -> str:
        """Its name in messages."""
        return f"item {self.number}"

    @property
    def name(self) -> str:
        """Its command in words."""
        entry = dialect.enums["MAV_CMD"].get(self.command)
        known = entry.name.removeprefix("MAV_CMD_") if entry else "an unknown command"
        return f"{known} ({self.command})"

    @property
    def is_payload(self) -> bool:
        """Whether it is a command for a payload."""
        entry = dialect.enums["MAV_CMD"].get(self.command)
        return entry is not None and entry.name in PAYLOAD_COMMANDS

    def param(self, number: int) -> float:
        """A parameter from 1 to 7; 0 where the plan has no value."""
        return self.params[number - 1] or 0.0

    @property
    def position(self) -> LatLon | None:
        """Its position; None for "here"."""
        latitude, longitude = self.param(5), self.param(6)
        if latitude == longitude == 0:
            return None
        return check_degrees(self.item, latitude, longitude)

    @property
    def height(self) -> Height:
        """Its height.

        Raises:
            ItemRefused: the height refers to something that the vehicle does not know.
        """
        if self.frame in TERRAIN_FRAMES:
            what = f"its altitude is above the terrain (frame {self.frame}), which no mission knows"
            raise ItemRefused(self.item, what, f"its altitude has to be above home: {LEAVE_OUT}")
        if self.frame not in AMSL_FRAMES | RELATIVE_FRAMES:
            what = f"frame {self.frame} says no altitude"
            raise ItemRefused(self.item, what, f"its altitude has to be above home: {LEAVE_OUT}")
        if self.params[6] is None:
            raise ItemRefused(self.item, "has no altitude", "write one")
        return Height(self.params[6], self.frame in AMSL_FRAMES)

    def refused(self, why: str) -> ItemRefused:
        """The error for an item that cannot be imported."""
        return ItemRefused(self.item, f"{self.name} {why}", LEAVE_OUT)


@dataclass
class PlannedRoute:
    """What the items so far have asked for; fields as in `RoutePlan`."""

    takeoff: Height | None = None
    takeoff_item: str = ""
    takeoff_at: LatLon | None = None
    waypoints: list[Waypoint] = field(default_factory=list)
    acts: dict[int, list[Act]] = field(default_factory=dict)
    speeds_mps: list[float] = field(default_factory=list)
    first_waypoint: dict[int, int] = field(default_factory=dict)
    repeats_from: int | None = None
    ends: str = ""
    lands_at_last: bool = False
    notes: list[str] = field(default_factory=list)
    payload_items: list[ItemRefused] = field(default_factory=list)

    def visit(self, item: CommandItem, position: LatLon) -> None:
        """Adds a waypoint."""
        name = f"W{item.number.replace('.', '_')}"
        radius_m = item.param(2) if item.command == dialect.MAV_CMD_NAV_WAYPOINT else 0.0
        self.waypoints.append(
            Waypoint(item.item, name, position, item.height, (), radius_m if radius_m > 0 else None)
        )

    def do(self, act: Act) -> None:
        """Adds an act at the last waypoint; before the first one, at home."""
        self.acts.setdefault(len(self.waypoints) - 1, []).append(act)

    def plan(
        self,
        kind: str,
        home: LatLon | None,
        home_amsl_m: float | None,
        notes: tuple[str, ...],
        areas: tuple[PlanArea, ...] = (),
        rally: tuple[Waypoint, ...] = (),
    ) -> RoutePlan:
        """The plan, with the other content of its file.

        Args:
            home_amsl_m: 0 counts as unknown, because ground stations write it so.
        """
        home_note = ""
        if home is None and self.takeoff_at is not None:
            home = self.takeoff_at
            home_note = "home is where the plan takes off: it says nothing else of home"
        acts = {index: tuple(acts) for index, acts in self.acts.items()}
        waypoints = tuple(
            replace(waypoint, acts=acts.get(index, ()))
            for index, waypoint in enumerate(self.waypoints)
        )
        start, repeats_from = acts.get(-1, ()), self.repeats_from
        if self.takeoff_at and home and are_same(self.takeoff_at, home):
            start, waypoints = start + waypoints[0].acts, waypoints[1:]
            repeats_from = repeats_from and repeats_from - 1
        if not self.ends and self.waypoints:
            notes = (*notes, "the plan does not say how it ends; the mission comes home")
        return RoutePlan(
            kind=kind,
            home=home,
            home_amsl_m=home_amsl_m or None,
            home_note=home_note,
            takeoff=self.takeoff,
            takeoff_item=self.takeoff_item,
            start_acts=start,
            waypoints=waypoints,
            repeats_from=repeats_from,
            lands_at_last=self.lands_at_last,
            speeds_mps=tuple(self.speeds_mps),
            areas=areas,
            rally=rally,
            notes=notes + tuple(self.notes),
            unaddressed=tuple(self.payload_items),
            correction=LEAVE_OUT,
        )
