"""Checks that the vehicle can be at a mission's places: map, fence and altitudes."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from companion.documents import Document, DocumentReading
from companion.errors import MissionError
from companion.geometry import Ned, NorthEast, enu_from_ned, is_in_polygon
from companion.mission.coordinates import Coordinates
from companion.mission.places import Limits, Place
from companion.motion.grid import OccupancyGrid, distances_to_edge
from companion.motion.polygons import cells_of
from companion.vehicle_profile import VehicleProfile

USUAL_UP_M = 500.0
USUAL_REACH_M = 5_000.0
"""A limit beyond this was probably meant in another unit."""


def check_band(up_m: tuple[float, float], document: Document) -> None:
    """Checks the lowest and the highest altitude.

    Raises:
        MissionError: there is no altitude between them.
    """
    lowest, highest = up_m
    if not 0 <= lowest < highest:
        raise MissionError(
            f"the altitudes {lowest:g} to {highest:g} m are not a band above home",
            document.where("limits", "up_m"),
            "write [lowest, highest], metres above home, lowest first",
        )


def check_reach(limits: Limits, is_unusual: bool, document: Document) -> None:
    """Refuses limits that were probably meant in another unit.

    Args:
        limits: those of the mission.
        is_unusual: whether the author says that such limits are intended.
        document: the mission's YAML.

    Raises:
        MissionError: at the altitudes or the fence.
    """
    reach_m = max(abs(metres) for corner in limits.fence for metres in corner)
    for key, metres, usual_m in (
        ("up_m", limits.up_m[1], USUAL_UP_M),
        ("fence", reach_m, USUAL_REACH_M),
    ):
        if metres > usual_m and not is_unusual:
            raise MissionError(
                f"{key} reaches {metres:g} m from home, more than {usual_m:g} m",
                document.where("limits", key),
                "write metres; if it is meant, add unusual: true to the limits",
            )


def check_places(
    places: Mapping[str, Place],
    limits: Limits,
    grid: OccupancyGrid,
    vehicle: VehicleProfile,
    coordinates: Coordinates,
    document: Document,
    reading: DocumentReading,
) -> None:
    """Reports places too near to an obstacle, outside the fence, or outside the altitude band.

    Args:
        vehicle: the vehicle that needs room at them.
    """
    zoned = cells_of(grid, limits.keep_out.values())

    def check(place: Place) -> None:
        above_m = -place.position[2] - vehicle.clearance_m
        walls, kept = grid.at(above_m), zoned.at(above_m)
        problem = (
            _off_map_problem(place, grid)
            or _fence_problem(place, limits, vehicle.margin_m, coordinates)
            or _zone_problem(place, limits, vehicle.clearance_m)
            or _room_problem(place, walls, kept, vehicle.clearance_m, coordinates)
            or _altitude_problem(place, limits)
        )
        if problem:
            what, hint = problem
            where = document.key_at("places", place.name)
            raise MissionError(f"place {place.name} {what}", where, hint)

    for place in places.values():
        reading.read(("places", place.name), check, place)


def _off_map_problem(place: Place, grid: OccupancyGrid) -> tuple[str, str] | None:
    if grid.contains(*grid.cell(place.position[:2])):
        return None
    south, west = grid.origin
    rows, cols = grid.occupied.shape
    north, east = south + rows * grid.cell_m, west + cols * grid.cell_m
    if grid.is_open:
        return "is far outside the fence", "move it inside, or widen limits.fence"
    return (
        "is outside the map",
        f"the map spans east_m {west:g} to {east:g}, north_m {south:g} to {north:g}",
    )


def _room_problem(
    place: Place,
    grid: OccupancyGrid,
    kept: OccupancyGrid,
    clearance_m: float,
    coordinates: Coordinates,
) -> tuple[str, str] | None:
    """The problem of a place in a cell without enough room, to which no route leads.

    Args:
        kept: the map, with keep-out zones marked as occupied.
    """
    north_east = place.position[:2]
    cell = grid.cell(north_east)
    if kept.distance_m[cell] >= clearance_m:
        return None
    nearest = _nearest_free(north_east, kept, clearance_m)
    advice = (
        f"the nearest point with room is {coordinates.in_words(nearest)}"
        if nearest
        else "no point of the map has that much room; check the map's resolution"
    )
    if grid.occupied[cell]:
        return "is in a wall, or where the map knows nothing", advice
    clearance = grid.clearance_m(north_east)
    if clearance < clearance_m:
        return f"is only {clearance:.2f} m from a wall, {clearance_m:g} m are needed", advice
    width, least = f"{grid.cell_m:g} m wide", f"{kept.distance_m[cell]:.2f} m"
    what = "is too near to a wall" + (" or a keep-out zone" if kept is not grid else "")
    what += f": its cell of the map, {width}, comes within {least} of it"
    return f"{what}, {clearance_m:g} m are needed", advice


def _nearest_free(position: NorthEast, grid: OccupancyGrid, clearance_m: float) -> NorthEast | None:
    """Returns the centre of the nearest cell with enough room; None if the map has none."""
    rows, cols = np.nonzero(grid.distance_m >= clearance_m)
    if rows.size == 0:
        return None
    row, col = grid.cell(position)
    best = int(np.argmin((rows - row) ** 2 + (cols - col) ** 2))
    return grid.centre(int(rows[best]), int(cols[best]))


def _fence_problem(
    place: Place, limits: Limits, margin_m: float, coordinates: Coordinates
) -> tuple[str, str] | None:
    """The problem of a place outside the fence, or so near that the gate holds the vehicle."""
    is_inside = is_in_polygon(place.position, limits.fence)
    gap_m = min(_distances_to_edges(place.position, limits.fence))
    if is_inside and gap_m >= margin_m:
        return None
    corners = ", ".join(map(coordinates.as_corner, limits.fence))
    advice = f"move it, or widen limits.fence: [{corners}]"
    if is_inside:
        return f"is only {gap_m:.2f} m from the fence, {margin_m:g} m are needed", advice
    return "is outside the fence", advice


def _distances_to_edges(position: Ned, fence: tuple[NorthEast, ...]) -> list[float]:
    north, east, _ = (np.array(metres) for metres in position)
    edges = zip(fence, (*fence[1:], fence[0]), strict=True)
    return [float(distances_to_edge(north, east, edge)) for edge in edges]


def _zone_problem(place: Place, limits: Limits, clearance_m: float) -> tuple[str, str] | None:
    """The problem of a place in a keep-out zone, or too near to one."""
    for name, zone in limits.keep_out.items():
        advice = f"move it, or change limits.keep_out.{name}"
        if is_in_polygon(place.position, zone):
            return f"is in the keep-out zone {name}", advice
        gap_m = min(_distances_to_edges(place.position, zone))
        if gap_m < clearance_m:
            what = f"is only {gap_m:.2f} m from the keep-out zone {name}"
            return f"{what}, {clearance_m:g} m are needed", advice
    return None


def _altitude_problem(place: Place, limits: Limits) -> tuple[str, str] | None:
    _, _, up_m = enu_from_ned(place.position)
    lowest, highest = limits.up_m
    if lowest <= up_m <= highest:
        return None
    return (
        f"is at {up_m:g} m, outside {lowest:g} to {highest:g} m",
        "change its up_m, or limits.up_m",
    )
