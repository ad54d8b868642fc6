"""The files that remember what this companion has written to autopilots, for the next program.

One file for fences and one for rally points: a JSON list of what was written, each a list of items,
[command, param1, latitude, longitude, frame, altitude] with latitude and longitude in 1e-7 degrees.
What cannot be read is as if it were not there: then what the vehicle has is somebody else's, and
the operator is asked. Written beside the run folders, on the ground alone.
"""

from __future__ import annotations

import json
import logging
import os
from collections.abc import Sequence
from pathlib import Path

from companion.mavlink.framing import dialect
from companion.mavlink.plan_transfer import PlanItem
from companion.vehicle.own_uploads import OwnItems, OwnUploads, UploadedItems

OWN_FENCES = "autopilot-fences.json"
OWN_RALLY_POINTS = "autopilot-rally-points.json"
MOST_BYTES = 1 << 20

log = logging.getLogger(__name__)


def own_uploads_in(folder: Path) -> OwnUploads:
    """What was written by programs with this folder; what is new is kept there, too."""
    folder = folder.expanduser()
    return OwnUploads(_own_items(folder / OWN_FENCES), _own_items(folder / OWN_RALLY_POINTS))


def _own_items(path: Path) -> OwnItems:
    def keep(written: Sequence[UploadedItems]) -> None:
        try:
            _write(path, written)
        except OSError as error:
            log.warning("%s is not written: %s", path, error)

    return OwnItems(_read(path), keep)


def _read(path: Path) -> list[UploadedItems]:
    try:
        if path.stat().st_size > MOST_BYTES:
            return []
        written = json.loads(path.read_text(encoding="utf-8"))
        return [tuple(_item(*item) for item in items) for items in written]
    except FileNotFoundError:
        return []
    except (OSError, ValueError, TypeError, OverflowError, RecursionError) as error:
        log.warning("%s is not read: %s", path, error)
        return []


def _item(
    command: int,
    first: float,
    x: int,
    y: int,
    frame: int = dialect.MAV_FRAME_GLOBAL,
    altitude_m: float = 0.0,
) -> PlanItem:
    return PlanItem(int(command), int(frame), float(first), int(x), int(y), float(altitude_m))


def _write(path: Path, written: Sequence[UploadedItems]) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    rows = [
        [(item.command, item.first, item.x, item.y, item.frame, item.altitude_m) for item in items]
        for items in written
    ]
    new = path.with_name(f".{path.name}.{os.getpid()}")
    new.write_text(json.dumps(rows), encoding="utf-8")
    new.replace(path)
