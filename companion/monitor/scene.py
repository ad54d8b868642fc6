"""Reads the scene.json of a run folder: the world in which the run takes place.

docs/run-folder.md describes the file. Lengths are metres; inside they become local NED.
"""

from __future__ import annotations

import base64
import json
import math
import zlib
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from companion.drawn_maps import Wall, walled
from companion.errors import MissionError
from companion.geometry import GlobalOrigin, NorthEast, ned_from_enu
from companion.motion.grid import OccupancyGrid
from companion.motion.profile import SpeedLimits
from companion.motion.region import Area, Disc, Region
from companion.motion.routes import PlaceRegion
from companion.record.events import SCENE_FILE, has_a_run, no_run_folder
from companion.vehicle_profile import VehicleProfile

MAX_CELLS = 16_000_000
NO_BAND = (-math.inf, -math.inf)


@dataclass(frozen=True, slots=True)
class Scene:
    """What the mission says about the world.

    Attributes:
        start_unix_s: t_s 0 of the events, by the clock of flight.tlog.
        fence: corners, north and east.
        keep_out: corners of the keep-out zones, by name.
        walls: the low ones.
        speed_limits: by which routes are chosen.
        clearance_m: distance of routes from obstacles.
        up_m: the altitude band for routes over walls.
        anchor: where north 0, east 0 lies on the earth, if the mission says so.
    """

    name: str
    start_unix_s: float
    grid: OccupancyGrid
    fence: tuple[NorthEast, ...]
    keep_out: dict[str, tuple[NorthEast, ...]]
    walls: tuple[Wall, ...]
    sites: dict[str, PlaceRegion]
    clearance_m: float
    speed_limits: SpeedLimits
    anchor: GlobalOrigin | None = None
    up_m: tuple[float, float] = NO_BAND


def read_scene(folder: Path) -> Scene:
    """The scene of a run folder.

    Raises:
        MissionError: there is none, or it is not as documented.
    """
    path = folder / SCENE_FILE
    try:
        data = json.loads(path.read_bytes(), parse_float=_finite, parse_constant=_finite)
    except OSError as error:
        if not has_a_run(folder):
            raise no_run_folder(folder, SCENE_FILE, error) from error
        raise MissionError(f"{path} is missing, and nothing shows the run without it") from error
    except (ValueError, RecursionError) as error:
        raise MissionError(f"{path}: this is not JSON") from error
    try:
        return _scene(data)
    except (AttributeError, KeyError, OverflowError, TypeError, ValueError, zlib.error) as error:
        raise MissionError(f"{path}: not as docs/run-folder.md describes it: {error}") from error


def _finite(text: str) -> float:
    number = float(text)
    if not math.isfinite(number):
        raise ValueError(f"{text} is not a number of a scene")
    return number


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
    is_open = bool(about.get("open", False))  # earlier scenes lack it
    cells = bits.reshape(shape).astype(np.bool_)
    walls = [Wall(_polygon(w["corners"]), float(w["up_m"])) for w in data.get("low_walls", ())]
    grid = walled(OccupancyGrid(cells, float(about["cell_m"]), origin, is_open), walls)
    sites = {
        str(place["name"]): PlaceRegion(
            ned_from_enu(*map(float, place["enu"])), _region(place), place["in_task"]
        )
        for place in data["places"]
    }
    fence = _polygon(data["fence"])
    keep_out = {str(zone): _polygon(each) for zone, each in data.get("keep_out", {}).items()}
    profile = VehicleProfile()  # earlier scenes lack what follows
    clearance_m = float(data.get("clearance_m", profile.clearance_m))
    usual = SpeedLimits(profile.speed_mps, profile.acceleration_mps2, profile.jerk_mps3)
    told = data.get("speed_limits", asdict(usual))
    limits = SpeedLimits(**{key: float(most) for key, most in told.items()})
    low_m, high_m = map(float, data.get("up_m", NO_BAND))
    return Scene(
        name=str(data["name"]),
        start_unix_s=float(data["start_unix_s"]),
        grid=grid,
        fence=fence,
        keep_out=keep_out,
        walls=tuple(walls),
        sites=sites,
        clearance_m=clearance_m,
        speed_limits=limits,
        anchor=_anchor(data.get("anchor")),
        up_m=(low_m, high_m),
    )


def _anchor(degrees: list[float] | None) -> GlobalOrigin | None:
    if degrees is None:
        return None
    latitude, longitude = map(float, degrees)
    return GlobalOrigin(latitude, longitude, 0.0)


def _region(place: dict[str, Any]) -> Region:
    if "corners" in place:
        return Area(_polygon(place["corners"]))
    return Disc(float(place["radius_m"]))


def _polygon(corners: list[tuple[float, float]]) -> tuple[NorthEast, ...]:
    return tuple((float(north), float(east)) for east, north in corners)
