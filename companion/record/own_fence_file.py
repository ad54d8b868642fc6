"""The file that remembers which fences this companion has written, from one program to the next.

One JSON list of fences, each a list of items: [command, param1, latitude, longitude] in 1e-7
degrees. What cannot be read is as if it were not there: then the fence of the vehicle is somebody
else's, and the operator is asked. Written beside the run folders, on the ground alone.
"""

from __future__ import annotations

import json
import logging
import os
from collections.abc import Sequence
from pathlib import Path

from companion.mavlink.framing import dialect
from companion.mavlink.plan_transfer import PlanItem
from companion.vehicle.own_fences import FenceItems, OwnFences

OWN_FENCES = "autopilot-fences.json"
MOST_BYTES = 1 << 20

log = logging.getLogger(__name__)


def own_fences_in(folder: Path) -> OwnFences:
    """The fences that were written by programs with this folder; new ones are kept there, too."""
    path = folder.expanduser() / OWN_FENCES

    def keep(fences: Sequence[FenceItems]) -> None:
        try:
            _write(path, fences)
        except OSError as error:
            log.warning("%s is not written: %s", path, error)

    return OwnFences(_read(path), keep)


def _read(path: Path) -> list[FenceItems]:
    try:
        if path.stat().st_size > MOST_BYTES:
            return []
        fences = json.loads(path.read_text(encoding="utf-8"))
        return [tuple(_item(*item) for item in fence) for fence in fences]
    except FileNotFoundError:
        return []
    except (OSError, ValueError, TypeError, OverflowError, RecursionError) as error:
        log.warning("%s is not read: %s", path, error)
        return []


def _item(command: int, first: float, x: int, y: int) -> PlanItem:
    return PlanItem(int(command), dialect.MAV_FRAME_GLOBAL, float(first), int(x), int(y))


def _write(path: Path, fences: Sequence[FenceItems]) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    rows = [[(each.command, each.first, each.x, each.y) for each in fence] for fence in fences]
    new = path.with_name(f".{path.name}.{os.getpid()}")
    new.write_text(json.dumps(rows), encoding="utf-8")
    new.replace(path)
