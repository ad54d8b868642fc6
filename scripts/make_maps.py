"""Draws the maps of the shipped missions.

Writes NAME.pgm and NAME.yaml into missions/maps for each map of `MAPS`, always the same bytes. All
lengths are metres from home: x is east, y is north. After a change of a wall, run the script again,
and check by tests/unit/motion/test_hall.py and tests/flights/test_shipped.py that the missions
still find what they rely on.

Usage: python scripts/make_maps.py [FOLDER]
"""

from __future__ import annotations

import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

Box = tuple[float, float, float, float]
"""West, south, east, north."""


@dataclass(frozen=True)
class Drawing:
    """A map: an outer wall of 0.2 m, walls and pillars.

    Attributes:
        edge: the edges of the map; the outer wall is inside it.
        pillars: east, north, radius.
    """

    edge: Box
    walls: tuple[Box, ...] = ()
    pillars: tuple[tuple[float, float, float], ...] = ()
    cell_m: float = 0.1

    @property
    def outer_walls(self) -> tuple[Box, ...]:
        """South, north, west, east."""
        west, south, east, north = self.edge
        return (
            (west, south, east, south + 0.2),
            (west, north - 0.2, east, north),
            (west, south, west + 0.2, north),
            (east - 0.2, south, east, north),
        )


MAPS = {
    "hall": Drawing(
        edge=(-2.0, -2.0, 22.0, 14.0),
        walls=(
            (5.0, 7.6, 8.8, 7.8),  # western part of the gallery
            (11.4, 7.6, 14.6, 7.8),  # eastern part of the gallery
            (7.6, 10.6, 7.8, 13.8),  # screen in the gallery
            (12.0, -1.8, 12.2, 5.0),  # between the workshops
        ),
        pillars=(
            (1.8, 5.6, 0.4),
            (4.6, 0.2, 0.4),
            (8.6, 3.2, 0.4),
            (13.0, 11.2, 0.4),
            (17.2, 6.0, 0.5),
        ),
    ),
    # Two rooms, joined by a corridor, a doorway, and a passage in the north.
    "rooms": Drawing(
        edge=(-2.0, -2.0, 18.0, 14.0),
        walls=(
            (5.0, -1.8, 11.0, -0.6),  # south of the corridor
            (5.0, 1.4, 11.0, 7.6),  # between the corridor and the doorway
            (5.0, 9.4, 11.0, 10.4),  # between the doorway and the passage
        ),
    ),
    # Four rows of seven pillars.
    "big_hall": Drawing(
        edge=(-3.0, -3.0, 57.0, 37.0),
        walls=((12.0, 10.0, 12.4, 24.0), (26.0, 15.0, 40.0, 15.4), (42.0, 20.0, 42.4, 30.0)),
        pillars=tuple((4.0 + 8.0 * i, 5.0 + 8.0 * j, 0.6) for i in range(7) for j in range(4)),
        cell_m=0.2,
    ),
}

YAML = """\
# Drawn by scripts/make_maps.py; the format is ROS map_server's.
image: {name}.pgm
resolution: {cell_m}
origin: [{west_m}, {south_m}, 0.0]
negate: 0
occupied_thresh: 0.65
free_thresh: 0.196
mode: trinary
"""


def occupied_cells(drawing: Drawing) -> npt.NDArray[np.bool_]:
    """(rows, cols) cells whose centre lies in a wall or a pillar, row 0 southmost."""
    west, south, east, north = drawing.edge
    cell_m = drawing.cell_m
    rows, cols = round((north - south) / cell_m), round((east - west) / cell_m)
    y = south + cell_m * (np.arange(rows) + 0.5)[:, None]
    x = west + cell_m * (np.arange(cols) + 0.5)[None, :]
    occupied = np.zeros((rows, cols), dtype=np.bool_)
    for west_m, south_m, east_m, north_m in (*drawing.outer_walls, *drawing.walls):
        occupied |= (west_m < x) & (x < east_m) & (south_m < y) & (y < north_m)
    for east_m, north_m, radius_m in drawing.pillars:
        occupied |= np.hypot(x - east_m, y - north_m) < radius_m
    return occupied


def pgm(drawing: Drawing) -> bytes:
    """The image as a binary PGM (netpbm's P5): 0 is occupied, 254 is free."""
    grey = np.where(occupied_cells(drawing)[::-1], 0, 254).astype(np.uint8)  # top row northmost
    return b"P5\n%d %d\n255\n" % (grey.shape[1], grey.shape[0]) + grey.tobytes()


def main(folder: Path) -> None:
    """Writes both files of each map into a folder."""
    for name, drawing in MAPS.items():
        west_m, south_m, _, _ = drawing.edge
        text = YAML.format(name=name, cell_m=drawing.cell_m, west_m=west_m, south_m=south_m)
        (folder / f"{name}.pgm").write_bytes(pgm(drawing))
        (folder / f"{name}.yaml").write_text(text, encoding="utf-8")


if __name__ == "__main__":
    default = Path(__file__).resolve().parent.parent / "missions" / "maps"
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else default)
