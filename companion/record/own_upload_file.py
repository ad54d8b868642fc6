"""The files that remember what this companion has written to autopilots, for later programs.

One file for fences and one for rally points: a JSON list of what was written, each a list of items,
[command, param1, latitude, longitude, frame, altitude] with latitude and longitude in 1e-7 degrees.
If it cannot be read, the vehicle's items count as somebody else's, and the operator is asked.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from companion.mavlink.framing import dialect
from companion.mavlink.item_transfer import StoredItem
from companion.record.remembered_file import remember, remembered
from companion.vehicle.own_uploads import OwnItems, UploadedItems

OWN_FENCES = "autopilot-fences.json"
OWN_RALLY_POINTS = "autopilot-rally-points.json"


def own_items_at(path: Path) -> OwnItems:
    """What programs with this file have written; new items are stored there."""
    return OwnItems(remembered(path, _read), lambda written: remember(path, _rows(written)))


def _rows(written: Sequence[UploadedItems]) -> list[Any]:
    return [
        [(item.command, item.first, item.x, item.y, item.frame, item.altitude_m) for item in items]
        for items in written
    ]


def _read(rows: Any) -> list[UploadedItems]:
    return [tuple(_item(*item) for item in items) for items in rows]


def _item(
    command: int,
    first: float,
    x: int,
    y: int,
    frame: int = dialect.MAV_FRAME_GLOBAL,
    altitude_m: float = 0.0,
) -> StoredItem:
    return StoredItem(int(command), int(frame), float(first), int(x), int(y), float(altitude_m))
