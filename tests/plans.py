"""Missions and fences as a client sends them."""

from collections.abc import Sequence
from typing import Any

from wire import NAN, Wire

from companion.geometry import Ned
from companion.mavlink.framing import dialect
from sitl.world.scenario import PX4_HOME

GLOBAL_INT, MISSION, RELATIVE_INT = 5, 2, 6
WAYPOINT, LOITER_TIME, RETURN, LAND, TAKEOFF, DELAY, JUMP, SPEED = 16, 19, 20, 21, 22, 93, 177, 178
ACCEPTED, ERROR, UNSUPPORTED_FRAME, UNSUPPORTED, NO_SPACE = 0, 1, 2, 3, 4
INVALID_SEQUENCE, CANCELLED = 13, 15


def place(
    command: int,
    point: Ned,
    *parameters: float,
    yaw_deg: float = NAN,
    kind: int = 0,
    autocontinue: int = 1,
) -> Any:
    """An item with a place: local north and east, and metres above home."""
    north, east, up = point
    lat_deg, lon_deg, _ = PX4_HOME.to_global((north, east, 0.0))
    first = (*parameters, 0.0, 0.0, 0.0)[:3]
    x, y = round(lat_deg * 1e7), round(lon_deg * 1e7)
    return dialect.MAVLink_mission_item_int_message(
        1, 1, 0, RELATIVE_INT, command, 0, autocontinue, *first, yaw_deg, x, y, up, kind
    )


def action(command: int, *parameters: float) -> Any:
    """An item without a place."""
    first = (*parameters, 0.0, 0.0, 0.0, 0.0)[:4]
    return dialect.MAVLink_mission_item_int_message(
        1, 1, 0, MISSION, command, 0, 1, *first, 0, 0, 0.0, 0
    )


def numbered(items: Sequence[Any]) -> list[Any]:
    """The items with their places in the list, the first marked as current."""
    for seq, item in enumerate(items):
        item.seq, item.current = seq, int(seq == 0)
    return list(items)


def upload(wire: Wire, items: Sequence[Any], kind: int = 0) -> int:
    """Upload as a client does that answers each request; the type of the MISSION_ACK."""
    items = numbered(items)
    heard = len(wire.heard)
    wire.send(dialect.MAVLink_mission_count_message(1, 1, len(items), kind))
    for _ in range(4 * len(items) + 8):
        if any(h.name == "MISSION_ACK" for h in wire.heard[heard:]):
            break
        wire.send(items[wire.last("MISSION_REQUEST_INT").seq])
    return int(wire.last("MISSION_ACK").type)


def download(wire: Wire, kind: int = 0) -> list[Any]:
    """What a store holds, by the protocol."""
    wire.send(dialect.MAVLink_mission_request_list_message(1, 1, kind))
    items = []
    for seq in range(wire.last("MISSION_COUNT").count):
        wire.send(dialect.MAVLink_mission_request_int_message(1, 1, seq, kind))
        items.append(wire.last("MISSION_ITEM_INT"))
    wire.send(dialect.MAVLink_mission_ack_message(1, 1, ACCEPTED, kind))
    return items
