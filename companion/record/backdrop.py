"""The background of a flight's picture: walls, shaded by distance, fence, zones and places."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patches import Circle, Patch, Polygon

from companion.geometry import Ned, NorthEast, enu_from_ned
from companion.mission.model import Mission
from companion.motion.grid import OccupancyGrid
from companion.motion.region import Region

SHADE_LIMIT_M = 3.0
"""A cell farther than this from the next obstacle is white."""
FENCE, ZONE, LOW_WALL, PLACE = "tab:purple", "tab:red", "tab:gray", "tab:orange"


@dataclass(frozen=True, slots=True, eq=False)
class Backdrop:
    """The world of a flight.

    Attributes:
        fence: corners, north and east.
        keep_out: corners of the keep-out zones.
        low_walls: corners of the walls that can be flown over.
        places: position and region of each.
    """

    grid: OccupancyGrid
    fence: tuple[NorthEast, ...]
    keep_out: tuple[tuple[NorthEast, ...], ...]
    low_walls: tuple[tuple[NorthEast, ...], ...]
    places: Mapping[str, tuple[Ned, Region]]

    @property
    def legend(self) -> list[Line2D | Patch]:
        """What its lines and areas mean."""
        entries: list[Line2D | Patch] = [Line2D([], [], color=FENCE, linestyle="--", label="fence")]
        if self.keep_out:
            entries.append(Patch(facecolor="none", edgecolor=ZONE, hatch="//", label="keep out"))
        if self.low_walls:
            entries.append(
                Patch(facecolor="none", edgecolor=LOW_WALL, hatch="xx", label="low wall")
            )
        place = Line2D([], [], color=PLACE, marker="o", markersize=5, label="place, its region")
        return [*entries, place]

    def draw(self, axis: Axes) -> None:
        """Draws all but the names of places; east to the right, north up, metres."""
        grid = self.grid
        rows, cols = grid.occupied.shape
        north, east = grid.origin
        extent = (east, east + cols * grid.cell_m, north, north + rows * grid.cell_m)
        near = np.minimum(grid.distance_m / SHADE_LIMIT_M, 1.0)
        shade = np.where(grid.occupied, 0.0, 0.25 + 0.75 * near)
        axis.imshow(shade, cmap="gray", vmin=0.0, vmax=1.0, origin="lower", extent=extent)
        axis.add_patch(_polygon(self.fence, edgecolor=FENCE, linestyle="--"))
        for wall in self.low_walls:
            axis.add_patch(_polygon(wall, edgecolor=LOW_WALL, hatch="xx"))
        for zone in self.keep_out:
            axis.add_patch(_polygon(zone, edgecolor=ZONE, hatch="//"))
        for position, region in self.places.values():
            x, y, _ = enu_from_ned(position)
            if corners := region.outline():
                axis.add_patch(_polygon(corners, edgecolor=PLACE))
            else:
                radius_m = region.inner_m(position)
                axis.add_patch(Circle((x, y), radius_m, facecolor="none", edgecolor=PLACE))
            axis.plot(x, y, "o", color=PLACE, markersize=5)
        axis.set_aspect("equal")
        axis.set_xlabel("east [m]")
        axis.set_ylabel("north [m]")


def backdrop_of(mission: Mission) -> Backdrop:
    """The world as a mission knows it at the start."""
    return Backdrop(
        mission.grid,
        tuple(mission.limits.fence),
        tuple(mission.limits.keep_out.values()),
        tuple(wall.corners for wall in mission.walls if wall.up_m is not None),
        {name: (place.position, place.region) for name, place in mission.places.items()},
    )


def _polygon(
    corners: Iterable[NorthEast], edgecolor: str, hatch: str | None = None, linestyle: str = "-"
) -> Polygon:
    points = [(east, north) for north, east in corners]
    return Polygon(points, facecolor="none", edgecolor=edgecolor, hatch=hatch, linestyle=linestyle)
