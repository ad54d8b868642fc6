"""Pictures of flights: the map once, as a symbol, and the track and obstacles of each flight."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from html import escape
from typing import TYPE_CHECKING

import numpy as np

from companion.campaigns.charts import n
from companion.campaigns.outcomes import FlownRow
from companion.errors import MissionError
from companion.mission.model import Mission

if TYPE_CHECKING:
    from companion.campaigns.kit import Kit
    from companion.flights.simulated_world import Scenario
    from companion.motion.grid import OccupancyGrid

MARGIN_M = 1.0
MAP = "map"


class Pictures:
    """Pictures of the flights of a kit, all in one frame: the fence and what it contains.

    Args:
        kit: mission and scenario.
    """

    def __init__(self, kit: Kit) -> None:
        self._kit = kit
        north, east = zip(*kit.mission.limits.fence, strict=True)
        self._west, self._north = min(east) - MARGIN_M, max(north) + MARGIN_M
        self._width = max(east) + MARGIN_M - self._west
        self._height = self._north - min(north) + MARGIN_M

    @property
    def symbol(self) -> str:
        """The map, fence, zones and places as an SVG symbol that each picture uses."""
        mission = self._kit.mission
        zones = "".join(
            f'<polygon class="zone" points="{self._points(zone)}"/>'
            for zone in mission.limits.keep_out.values()
        )
        return (
            f'<svg class="symbols" aria-hidden="true"><symbol id="{MAP}" viewBox="{self._box}">'
            f'<path class="wall" d="{self._walls()}"/>'
            f'<polygon class="fence" points="{self._points(mission.limits.fence)}"/>'
            f"{zones}{''.join(self._places(mission))}</symbol></svg>"
        )

    def picture(self, flown: FlownRow) -> str:
        """One flight: its obstacles, its track, and where it failed or ended."""
        track = self._points([(north, east) for east, north in flown.track])
        end = ""
        if flown.east_m is not None and flown.north_m is not None:
            x, y, r = flown.east_m - self._west, self._north - flown.north_m, self._width / 60
            there, back = f"l{n(2 * r)} {n(2 * r)}", f"l{n(-2 * r)} {n(2 * r)}"
            cross = f"M{n(x - r)} {n(y - r)}{there}m0 {n(-2 * r)}{back}"
            end = f'<path class="end-mark" d="{cross}"/>'
        label = f'role="img" aria-label="the track of row {flown.row.index}"'
        return (
            f'<svg class="flight" viewBox="{self._box}" {label}><use href="#{MAP}"/>'
            f"{''.join(self._obstacles(flown))}"
            f'<polyline class="track" points="{track}"/>{end}</svg>'
        )

    @property
    def _box(self) -> str:
        return f"0 0 {n(self._width)} {n(self._height)}"

    def _points(self, corners: Sequence[tuple[float, float]]) -> str:
        points = ((east - self._west, self._north - north) for north, east in corners)
        return " ".join(f"{n(x)},{n(y)}" for x, y in points)

    def _places(self, mission: Mission) -> Iterator[str]:
        size = self._width / 28
        for place in mission.places.values():
            north, east, _ = place.position
            x, y = n(east - self._west), n(self._north - north)
            yield f'<circle class="place" cx="{x}" cy="{y}" r="{n(size / 5)}"/>'
            is_west = east - self._west < self._width / 2
            side, anchor = (1, "start") if is_west else (-1, "end")
            style = f'dx="{n(side * size / 3)}" text-anchor="{anchor}" font-size="{n(size)}"'
            yield f'<text x="{x}" y="{y}" {style}>{escape(place.name)}</text>'

    def _walls(self) -> str:
        grid = self._kit.scenario.grid
        return "".join(self._runs(grid)) if grid is not None else ""

    def _runs(self, grid: OccupancyGrid) -> Iterator[str]:
        """The occupied cells, with one box for each run of cells in a row."""
        (south, west), cell = grid.origin, grid.cell_m
        for row, occupied in enumerate(grid.occupied):
            edges = np.flatnonzero(np.diff(np.concatenate(([0], occupied.astype(np.int8), [0]))))
            top = self._north - south - (row + 1) * cell
            for first, last in zip(edges[::2], edges[1::2], strict=True):
                left, width = west + first * cell - self._west, (last - first) * cell
                yield f"M{n(left)} {n(top)}h{n(width)}v{n(cell)}h{n(-width)}z"

    def _obstacles(self, flown: FlownRow) -> Iterator[str]:
        try:
            scenario: Scenario = self._kit.scenario.world(flown.row.values)[0]
        except MissionError:  # the row is invalid
            return
        for each in scenario.met_obstacles:
            (south, west), (north, east), r = each.south_west, each.north_east, each.radius_m
            x, y = west - r - self._west, self._north - north - r
            width, height = east - west + 2 * r, north - south + 2 * r
            box = f'x="{n(x)}" y="{n(y)}" width="{n(width)}" height="{n(height)}"'
            yield f'<rect class="obstacle" {box} rx="{n(r)}"/>'
