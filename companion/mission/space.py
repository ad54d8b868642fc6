"""Reads what a mission file says about space: its map, its limits and its places.

The mission's frame decides what coordinates mean (coordinates.py).
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import NamedTuple

from companion.documents import Document, DocumentReading
from companion.drawn_maps import Corner, MapEntry, Wall, drawn_map, polygon, walls_of
from companion.errors import MissionError
from companion.geometry import Ned, NorthEast, is_in_polygon, wrap_angle
from companion.maps import read_map
from companion.mission.coordinates import Coordinates
from companion.mission.places import Limits, Place
from companion.mission.python_call import PythonCall, check_names, parse_python
from companion.mission.schema import MissionFile
from companion.mission.sites import check_band, check_reach
from companion.mission.world_schema import PlaceEntry
from companion.motion.grid import OccupancyGrid
from companion.motion.polygons import MAX_CORNERS, do_overlap
from companion.motion.region import Area, Disc, Region
from companion.skills.authoring import FunctionKind

RADIUS_M = 0.6
"""Radius of a place's region if the place does not give one."""


class Space(NamedTuple):
    """Where a mission takes place; the attributes are those of `Mission`."""

    grid: OccupancyGrid
    map_file: str
    walls: tuple[Wall, ...]
    limits: Limits


def read_space(
    file: MissionFile,
    folder: Path,
    coordinates: Coordinates,
    document: Document,
    reading: DocumentReading,
) -> Space | None:
    """The map and the limits of a mission; None if some of them are unusable.

    Args:
        file: the mission.
        folder: where the relative name of a map file begins.
        coordinates: the meaning of coordinates.
        document: where the file's keys are.
        reading: the reading of the mission.
    """
    reading.read(("limits", "up_m"), check_band, file.limits.up_m, document)
    fence = None
    if reading.is_whole("map"):
        fence = reading.read(("limits", "fence"), _fence, file, coordinates, document)
    has_edge = reading.is_whole("limits", "fence")
    drawn = None
    if has_edge or isinstance(file.map, str):  # a drawn area may have the extent of the fence
        drawn = reading.read(("map",), _map, file, coordinates, document, folder, fence)
    if drawn is None or not has_edge:
        return None
    map_file, walls, grid = drawn
    edge, keep_out = fence or grid.corners, {}
    if not reading.knows("limits", "keep_out"):
        return None
    for name in file.limits.keep_out:
        keys = ("limits", "keep_out", name)
        zone = reading.read(keys, _zone, name, edge, file, coordinates, document)
        if zone is not None:
            keep_out[name] = zone
    limits = Limits(
        speed_mps=file.limits.speed_mps,
        up_m=file.limits.up_m,
        fence=edge,
        keep_out=keep_out,
        is_fence_written=fence is not None,
        is_beyond_sight=file.limits.beyond_sight,
    )
    for key in ("up_m", "unusual", "keep_out", "beyond_sight"):
        if not reading.is_whole("limits", key):
            return None
    reading.read(("limits",), check_reach, limits, file.limits.unusual, document)
    return Space(grid, map_file, walls, limits) if reading.knows("limits") else None


def read_places(
    file: MissionFile, coordinates: Coordinates, document: Document, reading: DocumentReading
) -> dict[str, Place]:
    """The places of a mission; unusable ones are left out."""
    places = {}
    for name, entry in file.places.items():
        keys = ("places", name)
        if place := reading.read(keys, _place, name, entry, file, coordinates, document):
            places[name] = place
    return places


def check_corners(space: Space, places: Iterable[Place], document: Document) -> None:
    """Refuses more corners than can be checked for each setpoint.

    Raises:
        MissionError: with the greatest allowed number.
    """
    limits, regions = space.limits, (place.region.outline() or () for place in places)
    fence = limits.fence if limits.is_fence_written else ()
    walls = (wall.corners for wall in space.walls)
    count = sum(map(len, (fence, *walls, *limits.keep_out.values(), *regions)))
    if count > MAX_CORNERS:
        raise MissionError(
            f"the mission's polygons have {count} corners, at most {MAX_CORNERS} are allowed",
            document.where(),
            "leave out what a metre more or less makes no difference to",
        )


def _map(
    file: MissionFile,
    coordinates: Coordinates,
    document: Document,
    folder: Path,
    fence: tuple[NorthEast, ...] | None,
) -> tuple[str, tuple[Wall, ...], OccupancyGrid]:
    """The name of the map's file, the walls, and the map itself."""
    with _located(document, "map"):
        map_file = str(folder / file.map) if isinstance(file.map, str) else ""
        entry = file.map if isinstance(file.map, MapEntry) else MapEntry()
        walls = walls_of(entry, partial(_map_corner, coordinates))
        grid = read_map(Path(map_file)) if map_file else drawn_map(entry, walls, fence)
    return map_file, walls, grid


def _map_corner(coordinates: Coordinates, corner: Corner, *keys: str | int) -> NorthEast:
    return coordinates.corner(corner, "map", *keys)


def _place(
    name: str, entry: PlaceEntry, file: MissionFile, coordinates: Coordinates, document: Document
) -> Place:
    position = coordinates.place(entry, "places", name)
    heading_deg = entry.heading_deg
    heading_rad = None if heading_deg is None else wrap_angle(math.radians(heading_deg))
    region = _region(name, entry, position, coordinates, document)
    suggesters, tests = (
        tuple(
            _asked((name, key, index), text, kind, file, document)
            for index, text in enumerate(texts)
        )
        for key, texts, kind in (
            ("suggesters", entry.suggesters, FunctionKind.SUGGESTER),
            ("tests", entry.tests, FunctionKind.PLACE_TEST),
        )
    )
    return Place(
        name,
        position,
        region,
        heading_rad=heading_rad,
        amsl_m=entry.amsl_m,
        suggesters=suggesters,
        tests=tests,
        found_by=entry.found_by or "",
    )


def _asked(
    keys: tuple[str, str, int], text: str, kind: FunctionKind, file: MissionFile, document: Document
) -> PythonCall:
    """A function that is asked about a place."""
    with document.locating("places", *keys):
        call = parse_python(text, kind)
    check_names(call, keys[0], [*file.places, *file.objects], document.where("places", *keys))
    return call


def _region(
    name: str, entry: PlaceEntry, position: Ned, coordinates: Coordinates, document: Document
) -> Region:
    if entry.corners is None:
        return Disc(RADIUS_M if entry.radius_m is None else entry.radius_m)
    keys = ("places", name, "corners")
    if entry.radius_m is not None:
        what, where = f"place {name} has both radius_m and corners", document.key_at(*keys)
        raise MissionError(what, where, "a region is a disc or a polygon: remove one of them")
    with _located(document, *keys):
        written = enumerate(entry.corners)
        corners = [coordinates.corner(corner, *keys, i) for i, corner in written]
        region = Area(polygon(corners, f"the region of {name}"))
        if not is_in_polygon(position, region.corners):
            hint = "the vehicle flies to the point, which has to be in the region"
            raise MissionError(f"place {name} lies outside its own corners", hint=hint)
    return region


def _fence(
    file: MissionFile, coordinates: Coordinates, document: Document
) -> tuple[NorthEast, ...] | None:
    if file.limits.fence is not None:
        with _located(document, "limits", "fence"):
            fence = enumerate(file.limits.fence)
            corners = [coordinates.corner(corner, "limits", "fence", i) for i, corner in fence]
            return polygon(corners, "the fence")
    if file.map is None or (isinstance(file.map, MapEntry) and file.map.east_m is None):
        raise MissionError(
            "the mission has neither a map nor a fence, so nobody knows where it may fly",
            document.where("limits"),
            "add one of them; fence: [[east, north], ...] in limits is enough",
        )
    return None


def _zone(
    name: str,
    fence: Sequence[NorthEast],
    file: MissionFile,
    coordinates: Coordinates,
    document: Document,
) -> tuple[NorthEast, ...]:
    """A keep-out zone."""
    keys = ("limits", "keep_out", name)
    with _located(document, *keys):
        written = enumerate(file.limits.keep_out[name])
        zone = polygon(
            [coordinates.corner(corner, *keys, i) for i, corner in written],
            f"the keep-out zone {name}",
        )
        if not do_overlap(zone, fence):
            what = f"the keep-out zone {name} lies outside the fence"
            raise MissionError(what, hint="nobody flies there anyway; correct or remove it")
    return zone


@contextmanager
def _located(document: Document, *keys: str) -> Iterator[None]:
    """Gives an error without a place the place of a value."""
    try:
        yield
    except MissionError as error:
        if error.where is not None:
            raise
        raise MissionError(error.what, document.where(*keys), error.hint) from error
