"""The files that store a flight memory for later programs, beside the run folders."""

from __future__ import annotations

from pathlib import Path

from companion.record.laid_frame_file import LAID_FRAMES, laid_frames_at
from companion.record.own_upload_file import OWN_FENCES, OWN_RALLY_POINTS, own_items_at
from companion.vehicle.flight_memory import FlightMemory


def flight_memory_in(folder: Path) -> FlightMemory:
    """The flight memory of all programs with this folder; updates are stored there."""
    folder = folder.expanduser()
    return FlightMemory(
        own_items_at(folder / OWN_FENCES),
        own_items_at(folder / OWN_RALLY_POINTS),
        laid_frames_at(folder / LAID_FRAMES),
    )
