"""What the clocks of a run showed at the same time: clocks.json.

A run has three clocks: its own seconds (`t_s`), the machine's clock, and the autopilot's, which
counts from its boot and stamps its log. Samples are taken when the run begins, when the vehicle is
armed (PX4 then begins a log), and when the run ends. docs/run-folder.md says how to align a log
with a run by them.
"""

from __future__ import annotations

import json
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from companion.vehicle.run_clocks import ClockReading

CLOCKS_FILE = "clocks.json"
VERSION = 1


def unix_of(clock_s: float) -> float:
    """The Unix time at which the machine's monotonic clock showed a time."""
    before_s, unix_s, after_s = time.monotonic(), time.time(), time.monotonic()
    return unix_s + clock_s - (before_s + after_s) / 2


class ClockFile:
    """The clocks.json of one run, rewritten with each sample.

    Args:
        folder: the folder of the run.
        is_continued: whether a cut-off run continues there, so that samples are added.
        write: writes a text to a file.
        unix_of: as the function of that name.
    """

    def __init__(
        self,
        folder: Path,
        is_continued: bool,
        write: Callable[[Path, str], None],
        unix_of: Callable[[float], float] = unix_of,
    ) -> None:
        self._path = folder / CLOCKS_FILE
        self._write = write
        self._unix_of = unix_of
        self._samples: list[dict[str, Any]] = read_clocks(folder) if is_continued else []

    def add(self, reading: ClockReading) -> None:
        """Adds a sample."""
        clock_s, offset = reading.clock_s, reading.autopilot
        unix_s = self._unix_of(clock_s) if clock_s is not None else None
        autopilot = None
        if offset is not None:
            boot_t_s, uncertainty_s = map(_rounded, offset)
            autopilot = {"boot_t_s": boot_t_s, "uncertainty_s": uncertainty_s}
        sample = {
            "at": reading.occasion,
            "t_s": _rounded(reading.time_s),
            "monotonic_s": _rounded(clock_s),
            "unix_s": _rounded(unix_s),
            "autopilot": autopilot,
        }
        self._samples.append(sample)
        text = json.dumps({"version": VERSION, "samples": self._samples}, indent=1)
        self._write(self._path, text + "\n")


def read_clocks(folder: Path) -> list[dict[str, Any]]:
    """The samples of a run; empty if the file is missing or damaged."""
    try:
        data = json.loads((folder / CLOCKS_FILE).read_bytes())
        return [dict(sample) for sample in data["samples"]]
    except (OSError, ValueError, KeyError, TypeError, RecursionError):
        return []


def _rounded(seconds: float | None) -> float | None:
    return None if seconds is None else round(seconds, 6)
