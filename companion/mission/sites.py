"""Checks that the vehicle can be at a mission's places: map, fence and altitudes."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from companion.documents import Document
from companion.errors import MissionError
from companion.geometry import NorthEast, enu_from_ned, is_in_polygon
from companion.mission.model import Limits, Place
from companion.motion.grid import OccupancyGrid


def check_limits(limits: Limits, document: Document) -> None:
    """Raises MissionError if the altitude band is empty."""
    lowest, highest = limits.up_m
    if not 0 <= lowest < highest:
        raise MissionError(
            f"the altitudes {lowest:g} to {highest:g} m are no band above home",
            document.where("limits", "up_m"),
            "write [lowest, highest], metres above home, lowest first",
        )


def check_places(
    places: Mapping[str, Place],
    limits: Limits,
    grid: OccupancyGrid,
    clearance_m: float,
    document: Document,
) -> None:
    """Checks every place.

    Args:
        clearance_m: least distance from a place to an obstacle.

    Raises:
        MissionError: at the key of the first place that is too near to an obstacle, outside the
            fence or outside the altitude band.
    """
    for place in places.values():
        problem = (
            _map_problem(place, grid, clearance_m)
            or _fence_problem(place, limits)
            or _altitude_problem(place, limits)
        )
        if problem:
            what, hint = problem
            where = document.key_at("places", place.name)
            raise MissionError(f"place {place.name} {what}", where, hint)


def _map_problem(place: Place, grid: OccupancyGrid, clearance_m: float) -> tuple[str, str] | None:
    north_east = (place.position[0], place.position[1])
    clearance = grid.clearance_m(north_east)
    if clearance >= clearance_m:
        return None
    if not grid.contains(*grid.cell(north_east)):
        south, west = grid.origin
        rows, cols = grid.occupied.shape
        north, east = south + rows * grid.cell_m, west + cols * grid.cell_m
        return (
            "is outside the map",
            f"the map spans east_m {west:g} to {east:g}, north_m {south:g} to {north:g}",
        )
    nearest = _nearest_free(north_east, grid, clearance_m)
    advice = (
        f"the nearest point with room is east_m: {nearest[1]:.2f}, north_m: {nearest[0]:.2f}"
        if nearest
        else "no point of the map has that much room; check the map's resolution"
    )
    if clearance == 0:
        return "is in a wall, or where the map knows nothing", advice
    return f"is only {clearance:.2f} m from a wall, {clearance_m:g} m are needed", advice


def _nearest_free(position: NorthEast, grid: OccupancyGrid, clearance_m: float) -> NorthEast | None:
    """Returns the centre of the nearest cell with enough room; None if the map has none."""
    rows, cols = np.nonzero(grid.distance_m >= clearance_m)
    if rows.size == 0:
        return None
    row, col = grid.cell(position)
    best = int(np.argmin((rows - row) ** 2 + (cols - col) ** 2))
    return grid.centre(int(rows[best]), int(cols[best]))


def _fence_problem(place: Place, limits: Limits) -> tuple[str, str] | None:
    if is_in_polygon(place.position, limits.fence):
        return None
    corners = ", ".join(f"[{east:g}, {north:g}]" for north, east in limits.fence)
    return "is outside the fence", f"move it, or widen limits.fence: [{corners}]"


def _altitude_problem(place: Place, limits: Limits) -> tuple[str, str] | None:
    _, _, up_m = enu_from_ned(place.position)
    lowest, highest = limits.up_m
    if lowest <= up_m <= highest:
        return None
    return (
        f"is at {up_m:g} m, outside {lowest:g} to {highest:g} m",
        "change its up_m, or limits.up_m",
    )
