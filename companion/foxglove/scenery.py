"""The world of a run as Foxglove's scene: walls, fence, keep-out zones, places.

What stands still is sent once, at the beginning; what else the lidar sees, when it sees it. Walls
of the map have no known height: they are drawn a little higher than the highest place. Each block
of occupied cells is one cube, so a hall has hundreds of cubes and not ten thousand.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from companion.flight_events.fence import FenceKept
from companion.foxglove.messages import MAP, Content, pose, vector
from companion.geometry import Ned, NorthEast
from companion.monitor.scene import Scene
from companion.motion.grid import OccupancyGrid
from companion.motion.routes import PlaceRegion

ABOVE_M = 1.0
CORNERS = 32
"""Corners of the polygon that stands for a disc."""
LINE_PIXELS = 2.0
LABEL_PIXELS = 14.0
LIFTED_M = 0.05

GREY = {"r": 0.45, "g": 0.45, "b": 0.5, "a": 0.9}
ORANGE = {"r": 0.9, "g": 0.5, "b": 0.1, "a": 0.9}
GREEN = {"r": 0.1, "g": 0.6, "b": 0.2, "a": 1.0}
RED = {"r": 0.85, "g": 0.1, "b": 0.1, "a": 1.0}
BLUE = {"r": 0.1, "g": 0.4, "b": 0.9, "a": 1.0}
PRIMITIVES = "arrows cubes spheres cylinders lines triangles texts models".split()


class Block(NamedTuple):
    """A rectangle of adjacent cells: ranges of rows and columns, ends excluded."""

    row: int
    col: int
    rows: int
    cols: int


def world(scene: Scene) -> Content:
    """The content of SceneUpdate for all that stands still; times are added later."""
    top_m = _top_m(scene)
    entities = [entity("walls", cubes=list(_cubes(scene.grid, scene.grid.occupied, top_m, GREY)))]
    entities.append(entity("fence", lines=[_loop(scene.fence, 0.0, GREEN)]))
    entities += [
        entity(
            f"keep_out_{name}",
            lines=[_loop(zone, 0.0, RED), _loop(zone, top_m, RED)],
            texts=[_label(name, _middle(zone, top_m), RED)],
        )
        for name, zone in scene.keep_out.items()
    ]
    entities += [
        entity(f"low_wall_{number}", lines=[_loop(wall.corners, wall.up_m or 0.0, GREY)])
        for number, wall in enumerate(scene.walls, 1)
    ]
    entities += [_place(name, site) for name, site in scene.sites.items()]
    return {"deletions": [], "entities": entities}


def kept(scene: Scene, fence: FenceKept) -> Content:
    """The content of SceneUpdate for a fence of the autopilot's own."""
    top_m = _top_m(scene)
    entities = [
        entity(f"kept_fence_{number}", lines=[_loop(area, 0.0, GREEN)])
        for number, area in enumerate(fence.within, 1)
    ]
    entities += [
        entity(f"kept_zone_{number}", lines=[_loop(zone, 0.0, RED), _loop(zone, top_m, RED)])
        for number, zone in enumerate(fence.keep_out, 1)
    ]
    return {"deletions": [], "entities": entities}


def seen(grid: OccupancyGrid, occupied: npt.NDArray[np.bool_], top_m: float) -> Content:
    """The content of SceneUpdate for what the lidar sees that the map does not show."""
    cubes = list(_cubes(grid, occupied, top_m, ORANGE))
    return {"deletions": [], "entities": [entity("seen", cubes=cubes)]}


def _top_m(scene: Scene) -> float:
    """The upper end of what has no known height."""
    return max((-site.position[2] for site in scene.sites.values()), default=0.0) + ABOVE_M


def entity(name: str, **primitives: list[Content]) -> Content:
    """A part of the scene, which stays until another one of the same name replaces it."""
    return {
        "frame_id": MAP,
        "id": name,
        "lifetime": {"sec": 0, "nsec": 0},
        "frame_locked": False,
        "metadata": [],
        **{kind: primitives.get(kind, []) for kind in PRIMITIVES},
    }


def blocks(occupied: npt.NDArray[np.bool_]) -> list[Block]:
    """Occupied cells as blocks: runs within a row, joined over rows where they are equal.

    >>> blocks(np.array([[1, 1, 0], [1, 1, 1]], dtype=bool))
    [Block(row=0, col=0, rows=1, cols=2), Block(row=1, col=0, rows=1, cols=3)]
    """
    found: list[Block] = []
    open_runs: dict[tuple[int, int], Block] = {}
    for row, line in enumerate(occupied):
        edges = np.flatnonzero(np.diff(np.concatenate(([False], line, [False])).astype(np.int8)))
        runs = {(int(a), int(b)) for a, b in zip(edges[::2], edges[1::2], strict=True)}
        found += [block for run, block in open_runs.items() if run not in runs]
        open_runs = {
            run: open_runs[run]._replace(rows=open_runs[run].rows + 1)
            if run in open_runs
            else Block(row, run[0], 1, run[1] - run[0])
            for run in sorted(runs)
        }
    return found + list(open_runs.values())


def _cubes(
    grid: OccupancyGrid, occupied: npt.NDArray[np.bool_], top_m: float, color: Content
) -> Iterator[Content]:
    south, west = grid.origin
    for block in blocks(occupied):
        north_m = south + (block.row + block.rows / 2) * grid.cell_m
        east_m = west + (block.col + block.cols / 2) * grid.cell_m
        size = {"x": block.cols * grid.cell_m, "y": block.rows * grid.cell_m, "z": top_m}
        yield {"pose": pose((north_m, east_m, -top_m / 2)), "size": size, "color": color}


def _loop(corners: Sequence[NorthEast], up_m: float, color: Content) -> Content:
    return line([(north, east, -up_m) for north, east in corners], color, is_closed=True)


def line(points: Iterable[Ned], color: Content, is_closed: bool = False) -> Content:
    """A line of constant width on the screen."""
    return {
        "type": 1 if is_closed else 0,
        "pose": pose((0.0, 0.0, 0.0), math.pi / 2),
        "thickness": LINE_PIXELS,
        "scale_invariant": True,
        "points": [vector(point) for point in points],
        "color": color,
        "colors": [],
        "indices": [],
    }


def _place(name: str, site: PlaceRegion) -> dict[str, Any]:
    north, east, down = site.position
    corners: Sequence[NorthEast] | None = site.region.outline()
    if corners is None:
        radius_m = site.region.inner_m(site.position)
        turns = (2 * math.pi * k / CORNERS for k in range(CORNERS))
        corners = [(north + radius_m * math.cos(a), east + radius_m * math.sin(a)) for a in turns]
    label = _label(name, (north, east, down - LIFTED_M), BLUE)
    return entity(f"place_{name}", lines=[_loop(corners, -down, BLUE)], texts=[label])


def _middle(corners: Sequence[NorthEast], up_m: float) -> Ned:
    north_m, east_m = np.mean(corners, axis=0)
    return float(north_m), float(east_m), -up_m


def _label(text: str, position: Ned, color: Content) -> Content:
    """A text that faces the viewer."""
    return {
        "pose": pose(position),
        "billboard": True,
        "font_size": LABEL_PIXELS,
        "scale_invariant": True,
        "color": color,
        "text": text,
    }
