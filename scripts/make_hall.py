"""Draws the hall: the indoor map that the surveillance mission flies in.

Writes missions/maps/hall.pgm and hall.yaml, the same bytes each time. The hall is 24 m x 16 m,
seen from the home position, which lies 2 m from its south-west corner in both axes: x (east)
runs from -2 to 22, y (north) from -2 to 14. Change a wall here, run the script again, and see
whether tests/unit/motion/test_hall.py still finds the properties that the mission relies on.

Usage: python scripts/make_hall.py [FOLDER]
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import numpy.typing as npt

CELL_M = 0.1
WEST_M, SOUTH_M, EAST_M, NORTH_M = -2.0, -2.0, 22.0, 14.0

# West, south, east, north; metres east and north of the home position.
WALLS = {
    "south": (-2.0, -2.0, 22.0, -1.8),
    "north": (-2.0, 13.8, 22.0, 14.0),
    "west": (-2.0, -2.0, -1.8, 14.0),
    "east": (21.8, -2.0, 22.0, 14.0),
    "gallery, western part": (5.0, 7.6, 8.8, 7.8),
    "gallery, eastern part": (11.4, 7.6, 14.6, 7.8),
    "screen in the gallery": (7.6, 10.6, 7.8, 13.8),
    "between the workshops": (12.0, -1.8, 12.2, 5.0),
}
# East, north, radius.
PILLARS = (
    (1.8, 5.6, 0.4),
    (4.6, 0.2, 0.4),
    (8.6, 3.2, 0.4),
    (13.0, 11.2, 0.4),
    (17.2, 6.0, 0.5),
)

YAML = f"""\
# Drawn by scripts/make_hall.py; the format is ROS map_server's.
image: hall.pgm
resolution: {CELL_M}
origin: [{WEST_M}, {SOUTH_M}, 0.0]
negate: 0
occupied_thresh: 0.65
free_thresh: 0.196
mode: trinary
"""


def occupied_cells() -> npt.NDArray[np.bool_]:
    """(rows, cols) cells whose centre lies in a wall or a pillar, row 0 southmost."""
    rows, cols = round((NORTH_M - SOUTH_M) / CELL_M), round((EAST_M - WEST_M) / CELL_M)
    north = SOUTH_M + CELL_M * (np.arange(rows) + 0.5)[:, None]
    east = WEST_M + CELL_M * (np.arange(cols) + 0.5)[None, :]
    occupied = np.zeros((rows, cols), dtype=np.bool_)
    for west_m, south_m, east_m, north_m in WALLS.values():
        occupied |= (west_m < east) & (east < east_m) & (south_m < north) & (north < north_m)
    for east_m, north_m, radius_m in PILLARS:
        occupied |= np.hypot(east - east_m, north - north_m) < radius_m
    return occupied


def pgm() -> bytes:
    """The image as a binary PGM (netpbm's P5): 0 is occupied, 254 is free."""
    grey = np.where(occupied_cells()[::-1], 0, 254).astype(np.uint8)  # top row northmost
    return b"P5\n%d %d\n255\n" % (grey.shape[1], grey.shape[0]) + grey.tobytes()


def main(folder: Path) -> None:
    """Write both files into a folder."""
    (folder / "hall.pgm").write_bytes(pgm())
    (folder / "hall.yaml").write_text(YAML, encoding="utf-8")


if __name__ == "__main__":
    default = Path(__file__).resolve().parent.parent / "missions" / "maps"
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else default)
