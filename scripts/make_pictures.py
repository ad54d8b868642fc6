"""Draws missions/NAME.png: each shipped mission, flown in lockstep with seed 0.

It is the flight.png of `companion sim missions/NAME.yaml --speed max`, with fewer colours, so that
a page of them loads quickly.

Usage: python scripts/make_pictures.py [NAME ...]
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

from benches.shipped import MISSIONS, Shipped, shipped
from PIL import Image

from companion import simulate

COLOURS = 96
MOST_BYTES = 150_000


def draw(flight: Shipped, path: Path) -> None:
    """Flies a mission and draws it."""
    mission = flight.load()
    with tempfile.TemporaryDirectory() as name:
        simulate(mission, flight.scenario, folder=name)
        with Image.open(Path(name) / "flight.png") as image:
            few = image.convert("RGB").quantize(COLOURS, Image.Quantize.MAXCOVERAGE)
            few.save(path, optimize=True)
    size = path.stat().st_size
    assert size <= MOST_BYTES, f"{path} has {size} bytes"
    print(f"{path}  {size / 1000:.0f} kB")


def main(names: list[str]) -> None:
    """Draws the named missions, or all."""
    for flight in shipped():
        if not names or flight.name in names:
            draw(flight, MISSIONS / f"{flight.name}.png")


if __name__ == "__main__":
    main(sys.argv[1:])
