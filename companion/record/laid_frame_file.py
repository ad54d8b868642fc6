"""The file that remembers where missions' frames were laid (`vehicle/laid_frames.py`).

A JSON list. First the computer's boot: times since it mean nothing after another one. Then each
frame: [system, booted_s, north, east, down, altitude_m], and in the same list, if known, [latitude,
longitude, altitude] of the local frame's origin. Only Linux identifies a boot of the computer, and
counts the time since it through a sleep. On other systems each program lays its own frame.
"""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from companion.geometry import GlobalOrigin
from companion.record.remembered_file import remember, remembered
from companion.vehicle.laid_frames import LaidFrame, LaidFrames
from companion.vehicle.mission_frame import LaidHome

LAID_FRAMES = "mission-frames.json"
COMPUTER_BOOT = Path("/proc/sys/kernel/random/boot_id")


def laid_frames_at(path: Path, computer_boot: Path = COMPUTER_BOOT) -> LaidFrames | None:
    """What programs with this file remember; None on a computer without Linux.

    Args:
        path: the path of the file.
        computer_boot: a file whose content identifies a boot of the computer.
    """
    try:
        boot = computer_boot.read_text(encoding="ascii").strip()
    except (OSError, ValueError):
        return None

    def read(rows: Any) -> list[LaidFrame]:
        first, *others = rows
        return [_frame(*row) for row in others] if first == boot else []

    def keep(laid: Sequence[LaidFrame]) -> None:
        remember(path, [boot, *map(_row, laid)])

    return LaidFrames(_since_boot_s, remembered(path, read), keep)


def _since_boot_s() -> float:
    return time.clock_gettime(time.CLOCK_BOOTTIME)


def _frame(system: int, booted_s: float, *numbers: float) -> LaidFrame:
    north, east, down, altitude_m, *reference = map(float, numbers)
    if not all(map(math.isfinite, (booted_s, *numbers))):
        raise ValueError("a number is not finite")
    origin = GlobalOrigin(*reference) if reference else None
    home = LaidHome((north, east, down), altitude_m, origin)
    return LaidFrame(int(system), float(booted_s), home)


def _row(frame: LaidFrame) -> list[float]:
    laid, origin = frame.laid, frame.laid.reference
    about = [frame.system, frame.booted_s, *laid.local, laid.altitude_m]
    if origin is None:
        return about
    return [*about, origin.latitude_deg, origin.longitude_deg, origin.altitude_m]
