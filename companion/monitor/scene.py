"""Reads the scene.json of a run folder: the world in which the run takes place.

docs/run-folder.md describes the file. Lengths are metres; inside they become local NED.
"""

from __future__ import annotations

import base64
import json
import zlib
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from companion.errors import MissionError
from companion.geometry import NorthEast, ned_from_enu
from companion.motion.grid import OccupancyGrid
from companion.motion.routes import PlaceRegion
from companion.vehicle_profile import VehicleProfile

SCENE = "scene.json"
MAX_CELLS = 16_000_000


@dataclass(frozen=True, slots=True)
class Scene:
    """What the mission says of the world.

    Attributes:
        start_unix_s: t_s 0 of the events on the clock of flight.tlog.
        fence: north-east corners.
        clearance_m: that routes keep from obstacles.
    """

    name: str
    start_unix_s: float
    grid: OccupancyGrid
    fence: tuple[NorthEast, ...]
    sites: dict[str, PlaceRegion]
    clearance_m: float


def read_scene(folder: Path) -> Scene:
    """The scene of a run folder.

    Raises:
        MissionError: there is none, or it is not as documented.
    """
    path = folder / SCENE
    try:
        data = json.loads(path.read_bytes())
    except OSError as error:
        raise MissionError(
            f"{folder} cannot be shown: {SCENE} cannot be read: {error.strerror}",
            hint="companion sim and companion run print the folder of each run",
        ) from error
    except (ValueError, RecursionError) as error:
        raise MissionError(f"{path}: this is not JSON") from error
    try:
        return _scene(data)
    except (KeyError, TypeError, ValueError, zlib.error) as error:
        raise MissionError(f"{path}: not as docs/run-folder.md describes it: {error}") from error


def _scene(data: dict[str, Any]) -> Scene:
    about = data["map"]
    shape = (int(about["rows"]), int(about["cols"]))
    if not 0 < shape[0] * shape[1] <= MAX_CELLS:
        raise ValueError(f"a map of {shape[0]} times {shape[1]} cells")
    unpacker = zlib.decompressobj()
    packed = unpacker.decompress(base64.b64decode(about["occupied"]), MAX_CELLS)
    if len(packed) != -(-shape[0] * shape[1] // 8):
        raise ValueError(f"{len(packed)} bytes of cells")
    bits = np.unpackbits(np.frombuffer(packed, dtype=np.uint8), count=shape[0] * shape[1])
    origin = (float(about["north_m"]), float(about["east_m"]))
    grid = OccupancyGrid(bits.reshape(shape).astype(np.bool_), float(about["cell_m"]), origin)
    sites = {
        str(place["name"]): PlaceRegion(
            ned_from_enu(*map(float, place["enu"])), float(place["radius_m"]), place["in_task"]
        )
        for place in data["places"]
    }
    fence = tuple((float(north), float(east)) for east, north in data["fence"])
    clearance_m = float(data.get("clearance_m", VehicleProfile().clearance_m))  # absent at first
    return Scene(str(data["name"]), float(data["start_unix_s"]), grid, fence, sites, clearance_m)
