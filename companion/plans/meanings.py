"""What the commands of a flight plan mean in a mission: one class for each kind of meaning.

A task replaces the list of items. So a command that flies the vehicle otherwise than to a point, or
that depends on what happens, cannot be expressed and is refused.

Source: https://mavlink.io/en/messages/common.html#mav_commands.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Protocol

from companion.mavlink.framing import dialect
from companion.plans.commands import (
    LEAVE_OUT,
    PAYLOADS,
    CommandItem,
    PlannedRoute,
    not_an_item,
)
from companion.plans.route_plan import (
    Height,
    Hold,
    ItemRefused,
    ItemsRefused,
    LatLon,
    Send,
    Waypoint,
)

CLIMB, DESCENT = dialect.SPEED_TYPE_CLIMB_SPEED, dialect.SPEED_TYPE_DESCENT_SPEED
FLOWN = range(dialect.MAV_CMD_NAV_WAYPOINT, dialect.MAV_CMD_NAV_LAST + 1)
"""Numbers of the commands that lead the vehicle; the others are executed on the way."""


class Meaning(Protocol):
    """The meaning of a command."""

    def add(self, item: CommandItem, route: PlannedRoute) -> None:
        """Adds the command to the route.

        Raises:
            ItemRefused: a mission cannot express it.
        """


def required(item: CommandItem) -> LatLon:
    """The position of an item that needs one.

    Raises:
        ItemRefused: it has none.
    """
    position = item.position
    if position is None:
        raise ItemRefused(item.item, f"{item.name} has no position", LEAVE_OUT)
    return position


class LoiterItem:
    """A wait at a position; without one, where the vehicle is."""

    def add(self, item: CommandItem, route: PlannedRoute) -> None:
        """Adds a place and a wait."""
        if (position := item.position) is not None:
            route.visit(item, position)
        if item.param(1) > 0:
            route.do(Hold(item.param(1)))
        route.notes.append(f"{item.item}: {item.name} waits, and does not circle")


@dataclass(frozen=True, slots=True)
class VisitItem:
    """A point; `note` says what is lost of it."""

    note: str = ""

    def add(self, item: CommandItem, route: PlannedRoute) -> None:
        """Adds a place, and a wait if the vehicle holds there."""
        route.visit(item, required(item))
        if item.param(1) > 0:
            route.do(Hold(item.param(1)))
        if self.note:
            route.notes.append(f"{item.item}: {item.name} {self.note}")


class TakeOffItem:
    """The height of home; also a place, if it is not at home."""

    def add(self, item: CommandItem, route: PlannedRoute) -> None:
        """Accepts it only at the beginning."""
        if route.takeoff is not None or route.waypoints:
            raise item.refused("in the middle of a plan means nothing to a mission")
        route.takeoff, route.takeoff_at = item.height, item.position
        route.takeoff_item = item.item
        if item.position is not None:
            route.visit(item, item.position)


class ReturnHomeItem:
    """The end of the flight, at home."""

    def add(self, item: CommandItem, route: PlannedRoute) -> None:
        """Ends the route; nothing may follow."""
        route.ends = item.item


class LandThereItem:
    """The end of the flight: at a position; without one, where the vehicle is."""

    def add(self, item: CommandItem, route: PlannedRoute) -> None:
        """Adds a place at the height of the waypoint before, from which the vehicle lands."""
        route.lands_at_last = bool(route.waypoints)
        if (position := item.position) is not None:
            before = route.waypoints[-1].height if route.waypoints else route.takeoff
            if before is None:
                raise item.refused("comes first, so nothing says from how high")
            name = f"W{item.number.replace('.', '_')}"
            route.waypoints.append(Waypoint(item.item, name, position, before))
            route.lands_at_last = True
        route.ends = item.item


class SpeedItem:
    """A speed; -1 keeps the one before."""

    def add(self, item: CommandItem, route: PlannedRoute) -> None:
        """Takes the lowest speed as the mission's; ignores those of climbs and descents."""
        if item.param(1) in (CLIMB, DESCENT):
            route.notes.append(f"{item.item}: a speed of climbs or descents; left out")
        elif item.param(2) > 0:
            route.speeds_mps.append(item.param(2))


class JumpItem:
    """An endless loop."""

    def add(self, item: CommandItem, route: PlannedRoute) -> None:
        """Repeats the route from an item for ever."""
        if item.param(2) >= 0:
            raise item.refused(f"{item.param(2):g} times: a mission repeats for ever or not at all")
        index = route.first_waypoint.get(int(item.param(1)))
        if index is None or index >= len(route.waypoints):
            raise item.refused(f"leads to item {item.param(1):g}, and not back to a waypoint")
        route.repeats_from, route.ends = index, item.item


class DelayItem:
    """A wait where the vehicle is."""

    def add(self, item: CommandItem, route: PlannedRoute) -> None:
        """Adds a wait in seconds; refuses a time of day."""
        if item.param(1) <= 0:
            raise item.refused("waits for a time of day")
        route.do(Hold(item.param(1)))


class PayloadItem:
    """A command to a payload."""

    def add(self, item: CommandItem, route: PlannedRoute) -> None:
        """Adds the command; the plan does not say who receives it."""
        entry = dialect.enums["MAV_CMD"][item.command]
        params = [item.param(number) for number in range(1, 8)]
        height = item.height if entry.has_location and item.position is not None else None
        while params and params[-1] == 0 and height is None:
            params.pop()
        route.do(Send(entry.name, tuple(params), item.item, height))
        what = f"{item.name} is for a payload, and a plan does not say for which"
        advice = "name its component, e.g. --payload 100 (a camera) or --payload 154 (a gimbal), or"
        advice += f"\nleave all of them out: --leave-out {PAYLOADS}"
        route.payload_items.append(ItemRefused(item.item, what, advice))


@dataclass(frozen=True, slots=True)
class RefusedItem:
    """A command that a mission cannot express."""

    why: str

    def add(self, item: CommandItem, route: PlannedRoute) -> None:
        """Always refuses."""
        raise item.refused(self.why)


_PLANES = RefusedItem("is for planes")
_LOITER = RefusedItem("circles, for which a mission has no word")
_CONDITION = RefusedItem("depends on what happens in flight; a mission has events for that")
MEANINGS: dict[int, Meaning] = {
    16: VisitItem(),
    82: VisitItem("is flown to straight, not on a spline"),
    19: LoiterItem(),
    22: TakeOffItem(),
    20: ReturnHomeItem(),
    21: LandThereItem(),
    178: SpeedItem(),
    177: JumpItem(),
    93: DelayItem(),
    **dict.fromkeys((17, 18, 31), _LOITER),
    **dict.fromkeys((84, 85, 189, 3000), _PLANES),
    **dict.fromkeys((112, 113, 114, 115), _CONDITION),
    92: RefusedItem("hands the vehicle to another program"),
    94: RefusedItem("lands until a load touches the ground"),
}
"""Number of a command -> its meaning. All payload commands have the same one."""


def meaning_of(item: CommandItem) -> Meaning:
    """What an item means."""
    if item.is_payload:
        return PayloadItem()
    return MEANINGS.get(item.command, RefusedItem("has no meaning in a mission"))


def route_of(
    items: Iterable[CommandItem], leave_out: frozenset[str], groups: Iterable[str] = ()
) -> PlannedRoute:
    """What the items of a plan ask for, in order.

    Args:
        items: the items of the plan.
        leave_out: their numbers, or `PAYLOADS`.
        groups: numbers of groups of items that the reader has left out.

    Raises:
        ItemRefused: no item has a number that is to be left out.
        ItemsRefused: a mission cannot express some items.
    """
    route, refused = PlannedRoute(), list[ItemRefused]()
    numbers = {PAYLOADS, *groups}
    for item in items:
        numbers.add(item.number)
        route.first_waypoint[item.jump_id] = len(route.waypoints)
        if item.number in leave_out or (PAYLOADS in leave_out and item.is_payload):
            route.notes.append(f"{item.item}: {item.name} left out, as asked")
            continue
        try:
            if route.ends:
                raise item.refused(f"comes after {route.ends}, with which the mission ends")
            meaning_of(item).add(item, route)
        except ItemRefused as error:
            refused.append(error)
            if item.command in FLOWN:  # so that what follows is accepted
                route.waypoints.append(Waypoint(item.item, "refused", (0.0, 0.0), Height(0.0)))
    if unknown := sorted(leave_out - numbers):
        raise not_an_item(unknown[0])
    if refused:
        raise ItemsRefused(refused)
    return route
