"""When and where flight.png is drawn: after the flight, here or in a child process.

matplotlib takes 30 MB, which a companion that flies again and again should not keep. It lets a
child process draw each flight,

    python -P -m companion.record.drawing

which reads its parent's pickle on its standard input. Of a flight that was continued, the companion
has only the trail since then; `companion figure` draws that flight from its files.
"""

from __future__ import annotations

import pickle
import subprocess
import sys
from pathlib import Path

from companion.mission.model import Mission
from companion.python_child import python_module
from companion.record.trail import Trail


def draw_here(mission: Mission, trail: Trail, path: Path) -> None:
    """Draws a flight to a PNG file, in this process.

    Raises:
        OSError: it cannot be written.
    """
    from companion.record.backdrop import backdrop_of
    from companion.record.figure import draw_flight

    draw_flight(backdrop_of(mission), trail, path)


def draw_in_child(mission: Mission, trail: Trail, path: Path) -> None:
    """Draws a flight in a child process, and waits for it.

    Raises:
        OSError: the child has failed.
    """
    if not _does(python_module(__name__), pickle.dumps((mission, trail, path))):
        raise OSError(0, f"{path.name} cannot be drawn")


def draw_record_in_child(mission: Mission, trail: Trail, path: Path) -> None:
    """Draws the whole flight of a run folder in a child process; if that fails, the known trail.

    Raises:
        OSError: the child has failed.
    """
    if not _does(python_module("companion", "figure", str(path.parent), "--output", str(path))):
        draw_in_child(mission, trail, path)


def _does(command: list[str], heard: bytes = b"") -> bool:
    """Whether a child process has succeeded; waits for it."""
    done = subprocess.run(
        command,
        input=heard,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        start_new_session=True,  # Ctrl-C in a terminal is for the flight process only
        check=False,
    )
    return done.returncode == 0


if __name__ == "__main__":
    draw_here(*pickle.load(sys.stdin.buffer))
